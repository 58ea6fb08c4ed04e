// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Vec3.h"
#include "DeviceBridge/Device/Device.h"
#include "DeviceBridge/Safety/FaultCause.h"
#include "DeviceBridge/Timing/Clock.h"

namespace devicebridge::tools
{
/// Largest force at the handle in an acceptance [N].
constexpr double kMostForce = 1;

/// Force at the handle with which a device is tried [N]: kMostForce, or what its motors bear continuously if that is less. Zero if it
/// exerts no force, or no limit is known.
double trialForce(const DeviceInfo& info) noexcept;

/// What happened while a device pushed the hand. Lengths, speeds and forces are those at the handle.
struct PushOutcome
{
	double strongest = 0;                 ///< largest force that was sent [N]
	double moved = 0;                     ///< way of the handle along the force while it was held [m]
	double fastest = 0;                   ///< largest speed [m/s]
	double afterGuard = 0;                ///< largest force along the push that was sent later than a tick after the guard [N]
	bool guarded = false;                 ///< the handle moved too far or too fast, so the force was switched off
	bool handGone = false;                ///< the device reported that it is not held
	FaultCause cause = FaultCause::None;  ///< first fault
	double atEnd = 0;                     ///< largest force in the last tenth of a second, when none is wanted [N]
	bool interrupted = false;             ///< by a signal
};

/// Pushes along `direction` (unit length, in W): the force rises to `force` [N] in a second, holds for a second and falls in half a second.
/// The stepping thread's safety chain is in place. The force is switched off for good once the handle has moved by kGuardWay or is faster
/// than kGuardSpeed. Returns after 2.7 s, with the device at zero.
PushOutcome push(Device& device, Clock& clock, const ist::Vec3& direction, double force);
constexpr double kGuardWay = 0.04, kGuardSpeed = 0.3;  ///< [m, m/s]

/// What a stepping thread that sends no force sees while the device is unplugged.
struct LossOutcome
{
	FaultCause cause = FaultCause::None;  ///< None: the device was not lost in time
	double seconds = 0;                   ///< time until the loss was seen
	bool interrupted = false;
};
/// Runs until the device is lost: it does not answer, repeats its samples, or reports what is no pose. Every command is zero. At most for
/// `longest` [s].
LossOutcome waitForLoss(Device& device, Clock& clock, double longest);
}  // namespace devicebridge::tools
