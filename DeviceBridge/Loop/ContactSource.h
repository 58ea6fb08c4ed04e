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
	ist::Twist twist;  ///< velocity of the origin of T, in W
};

/// One body that the tool touches.
struct ToolContact
{
	ist::Wrench onTool;  ///< wrench on the tool, about its origin, in W
	ist::Vec3 point;     ///< point of contact, in W
	ist::Vec3 normal;    ///< direction in which the tool leaves the body: unit length, in W
	double volume = 0;   ///< overlap volume [m^3]
	int pairs = 0;
	const void* other = nullptr;  ///< the source's key for the body; for a Bullet source, its btCollisionObject
};

constexpr int kMaxToolContacts = 16;

/// Result of one step of the world.
struct ToolStep
{
	ToolState tool;
	ist::Wrench coupling;       ///< wrench of the virtual coupling on the tool, about the tool's origin, in W
	double couplingFactor = 1;  ///< present stiffness of the coupling over that of its gains, if it adapts (AdaptiveCoupling.h)
	ToolContact contacts[kMaxToolContacts];
	int contactCount = 0;
	double overlapVolume = 0;  ///< overlap volume of all contacts, also those beyond kMaxToolContacts [m^3]
	std::int64_t pairs = 0;
	double queryMicroseconds = 0;
	bool toolIsBroken = false;  ///< whether the tool has a twist that is not finite: a fault, so the device gets zero until it is cleared
	std::int64_t overdue = 0;   ///< time by which the step's input is later than expected [ns]; the force fades with it
};

/// The world in which the tool moves.
class ContactSource
{
public:
	virtual ~ContactSource() = default;
	/// Called before advance(), with the same arguments. A loop with several hands prepares the sources of all hands before it advances the
	/// first, so that all pull their tools before a world that they share takes its step (SteppingThread::addHand). While the device gives
	/// no usable sample, `hand` is the last one, without kHandPresent.
	virtual void prepare(double dt, const DeviceState& hand) noexcept
	{
		static_cast<void>(dt);
		static_cast<void>(hand);
	}
	/// Advances the world by `dt` [s] while the hand pulls the tool. On entry the contact count, volume, pairs, `overdue` and
	/// `toolIsBroken` of `step` are zero. The other fields are those of the last step.
	virtual void advance(double dt, const DeviceState& hand, ToolStep& step) noexcept = 0;
	/// A sentence that says why this source cannot be used, so that no stepping thread starts. Empty if it can be used.
	virtual const char* refusal() const noexcept { return ""; }
};
}  // namespace devicebridge
