// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>

#include "BulletISTCollision/Core/Base/Pose.h"
#include "DeviceBridge/Device/Device.h"

namespace devicebridge
{
/// The virtual tool T that the hand holds.
struct ToolState
{
	ist::Pose X_WT;
	ist::Twist twist;  ///< of the origin of T, in W
};

/// One body that the tool touches.
struct ToolContact
{
	ist::Wrench onTool;  ///< about the origin of the tool, in W
	ist::Vec3 point;     ///< in W
	ist::Vec3 normal;    ///< unit length, in W: the way in which the tool leaves
	double volume = 0;   ///< overlap [m^3]
	int pairs = 0;
	const void* other = nullptr;  ///< the body, by what the source knows it by: a Bullet source's btCollisionObject
};

constexpr int kMaxToolContacts = 16;

/// What one step of the world gave.
struct ToolStep
{
	ToolState tool;
	ist::Wrench coupling;       ///< that the virtual coupling exerts on the tool, about its origin, in W
	double couplingFactor = 1;  ///< its stiffness over that of its gains, where it adapts (AdaptiveCoupling.h)
	ToolContact contacts[kMaxToolContacts];
	int contactCount = 0;
	double overlapVolume = 0;  ///< over all contacts, also those beyond kMaxToolContacts [m^3]
	std::int64_t pairs = 0;
	double queryMicroseconds = 0;
	bool toolIsBroken = false;  ///< the step left the tool a twist that is not finite: a fault, and the device gets zero until cleared
	std::int64_t overdue = 0;   ///< by how much what the step was computed from is later than expected; the force fades with it [ns]
};

/// The world in which the tool moves.
class ContactSource
{
public:
	virtual ~ContactSource() = default;
	/// Advances the world by `dt` [s] with the hand pulling the tool. `step` comes in with the contact count, volume,
	/// pairs and `toolIsBroken` at zero and the rest as the last step left it.
	virtual void advance(double dt, const DeviceState& hand, ToolStep& step) noexcept = 0;
	/// Why no hand may be led through this source, in a sentence, and no stepping thread starts. Empty when nothing stands in the way.
	virtual const char* refusal() const noexcept { return ""; }
};
}  // namespace devicebridge
