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
	ist::Vec3 position;           ///< position in W [m]
	ist::Quaternion orientation;  ///< orientation of the joint's frame in W
	double radius = 0;            ///< distance from the joint to the skin [m]
	bool tracked = false;         ///< whether the joint was tracked; if false, the other fields are undefined
};

/// Whether a quaternion from outside can be used as a rotation: its length is within 1e-3 of one. Floats and rounded text stay within that.
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

/// Moves every joint by x -> X (scale x).
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
