// SPDX-License-Identifier: Zlib
#pragma once

#include <array>
#include <cmath>

#include "BulletISTCollision/Core/Base/Pose.h"

namespace devicebridge
{
/// Joints of a hand, in the order and with the frames of XR_EXT_hand_tracking: -z points away from the wrist, y out of the back
/// of the hand (Khronos, OpenXR specification, section "Conventions of hand joints").
enum HandJointIndex
{
	kPalm,
	kWrist,
	kThumbMetacarpal,
	kThumbProximal,
	kThumbDistal,
	kThumbTip,
	kIndexMetacarpal,
	kIndexProximal,
	kIndexIntermediate,
	kIndexDistal,
	kIndexTip,
	kMiddleMetacarpal,
	kMiddleProximal,
	kMiddleIntermediate,
	kMiddleDistal,
	kMiddleTip,
	kRingMetacarpal,
	kRingProximal,
	kRingIntermediate,
	kRingDistal,
	kRingTip,
	kLittleMetacarpal,
	kLittleProximal,
	kLittleIntermediate,
	kLittleDistal,
	kLittleTip,
	kHandJoints
};

struct HandJoint
{
	ist::Vec3 position;           ///< in W [m]
	ist::Quaternion orientation;  ///< of the joint's frame in W
	double radius = 0;            ///< from the joint to the skin [m]
	bool tracked = false;         ///< false: the other fields say nothing
};

/// Whether a quaternion from outside may be taken for a rotation: within 1e-3 of unit length, as floats and rounded text are.
inline bool isNearUnit(const ist::Quaternion& q)
{
	constexpr double kUnitWithin = 1e-3;
	return std::fabs(std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w) - 1) <= kUnitWithin;
}

struct HandState
{
	bool left = false;
	std::array<HandJoint, kHandJoints> joints;
};

/// Every joint moved by x -> X (scale x).
inline void moveHand(HandState& hand, const ist::Pose& X, double scale = 1)
{
	const ist::Quaternion turn = ist::quaternion(X.rotation);
	for (HandJoint& joint : hand.joints)
	{
		joint.position = X * (scale * joint.position);
		joint.orientation = turn * joint.orientation;
		joint.radius *= scale;
	}
}
}  // namespace devicebridge
