// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Tools/AcceptancePush.h"

#include <algorithm>
#include <cmath>

#include "DeviceBridge/Loop/SteppingThread.h"
#include "DeviceBridge/Loop/StopSignals.h"
#include "DeviceBridge/Tools/WallWorld.h"

namespace devicebridge::tools
{
namespace
{
constexpr double kRise = 1, kHold = 1, kFall = 0.5, kRest = 0.2;  // [s]

/// A device that states a smaller peak, so that every stage of the safety chain stays below it, and no torque.
class WeakDevice final : public Device
{
public:
	WeakDevice(Device& device, double peak) : m_device(device), m_info(device.info())
	{
		m_info.peakForce = peak;
		m_info.continuousForce = m_info.continuousForce > 0 ? std::min(peak, m_info.continuousForce) : peak;
		m_info.peakTorque = m_info.continuousTorque = 0;
	}
	const DeviceInfo& info() const noexcept override { return m_info; }
	DeviceStatus open() noexcept override { return m_device.open(); }
	void close() noexcept override { m_device.close(); }
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override { return m_device.read(now, state); }
	DeviceStatus write(const DeviceCommand& command) noexcept override { return m_device.write(command); }

private:
	Device& m_device;
	DeviceInfo m_info;
};

/// Share of the force at a time since the beginning [s].
double shareAt(double t)
{
	if (t < kRise) return t / kRise;
	return std::clamp((kRise + kHold + kFall - t) / kFall, 0.0, 1.0);
}

/// A late tick or a handle that jumps is no loss.
bool isLoss(FaultCause cause)
{
	return cause == FaultCause::Disconnected || cause == FaultCause::Frozen || cause == FaultCause::InvalidState;
}
}  // namespace

double trialForce(const DeviceInfo& info) noexcept
{
	if (!(info.actuated & kTranslation) || !(info.peakForce > 0)) return 0;
	const double continuous = info.continuousForce > 0 ? info.continuousForce : info.peakForce / 4;
	return std::min(kMostForce, info.scale * std::min(continuous, info.peakForce));
}

PushOutcome push(Device& device, Clock& clock, const ist::Vec3& direction, double force)
{
	PushOutcome out;
	WallWorld world(0);
	WeakDevice weak(device, force / device.info().scale);
	SteppingThread thread(weak, world, clock);
	const StopSignals stop(thread);
	const double scale = device.info().scale;  // of the world's lengths over those of the handle
	const std::int64_t period = SteppingSettings().period;
	std::int64_t first = -1, sinceGuard = 0;
	ist::Vec3 start;
	thread.onHapticTick.addDelegate([&](const DeviceState& state, ist::Wrench& onHand) {
		if (first < 0) first = state.sampledAt, start = state.X_WH.translation;
		const ist::Vec3 way = state.X_WH.translation - start;
		const double time = 1e-9 * static_cast<double>(state.sampledAt - first), speed = norm(state.twist.linear) / scale;
		out.strongest = std::max(out.strongest, scale * norm(thread.sentWrench().force));
		if (time > kRise + kHold + kFall + kRest / 2) out.atEnd = std::max(out.atEnd, scale * norm(thread.sentWrench().force));
		out.fastest = std::max(out.fastest, speed);
		if (time < kRise + kHold) out.moved = dot(way, direction) / scale;
		out.handGone = out.handGone || !(state.flags & kHandPresent);
		if (out.guarded && ++sinceGuard > 1) out.afterGuard = std::max(out.afterGuard, scale * dot(thread.sentWrench().force, direction));
		out.guarded = out.guarded || speed > kGuardSpeed || norm(way) / scale > kGuardWay;
		if (!out.guarded) onHand.force += (shareAt(time) * force / scale) * direction;
	});
	thread.onFault.addDelegate([&](const Fault& fault) { out.cause = out.cause == FaultCause::None ? fault.cause : out.cause; });
	thread.run(static_cast<std::int64_t>(1e9 * (kRise + kHold + kFall + kRest)) / period);
	thread.stop();
	out.interrupted = StopSignals::caught() != 0;
	return out;
}

LossOutcome waitForLoss(Device& device, Clock& clock, double longest)
{
	LossOutcome out;
	WallWorld world(0);
	SteppingThread thread(device, world, clock);
	thread.enableForces(false);  // the over-speed brake acts without any contact
	const StopSignals stop(thread);
	const std::int64_t begin = clock.now();
	const auto seconds = [&] { return 1e-9 * static_cast<double>(clock.now() - begin); };
	thread.onFault.addDelegate([&](const Fault& fault) {
		if (out.cause == FaultCause::None && isLoss(fault.cause)) out.cause = fault.cause;
	});
	while (out.cause == FaultCause::None && seconds() < longest && !StopSignals::caught()) thread.run(10);
	out.seconds = seconds();
	out.interrupted = StopSignals::caught() != 0;
	return out;
}
}  // namespace devicebridge::tools
