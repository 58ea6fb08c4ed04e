// SPDX-License-Identifier: Zlib
#include <functional>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "DeviceBridge/Loop/SteppingThread.h"
#include "DeviceBridge/Tools/Commands.h"
#include "DeviceBridge/Tools/OpenedDevice.h"
#include "DeviceBridge/Tools/WallWorld.h"

namespace devicebridge::tools
{
namespace
{
struct Bench
{
	Device& device;
	Clock& clock;
	double stiffness;

	SteppingThread thread(WallWorld& world) const { return SteppingThread(device, world, clock); }
};

bool isZero(const ist::Wrench& w) { return w.force == ist::Vec3{} && w.torque == ist::Vec3{}; }

/// Runs one cycle of the hand: every sample is read, no fault occurs, and no force exceeds the device's peak.
bool staysWithinLimits(const Bench& bench)
{
	WallWorld world(bench.stiffness);
	SteppingThread thread = bench.thread(world);
	bool within = true;
	const DeviceInfo& info = bench.device.info();
	thread.onTransform.addDelegate([&](const DeviceState&) {
		within = within && norm(thread.sentWrench().force) <= info.peakForce * (1 + 1e-9) &&
			norm(thread.sentWrench().torque) <= info.peakTorque * (1 + 1e-9);
	});
	thread.run(1000);
	return within && thread.deviceErrors() == 0 && thread.faults() == 0;
}

/// Causes a fault half a second into the run. The next command must be zero, with the expected cause.
bool endsInZero(const Bench& bench, FaultCause cause, const std::function<void(ist::Wrench&)>& accident)
{
	WallWorld world(0);
	SteppingThread thread = bench.thread(world);
	bool now = false;
	thread.onHapticTick.addDelegate([&](const DeviceState&, ist::Wrench& w) {
		if (now) accident(w);
	});
	thread.run(500);
	now = true;
	thread.run(1);
	return isZero(thread.sentWrench()) && thread.faulted() && thread.faultCause() == cause;
}

bool obeysTheSwitch(const Bench& bench)
{
	WallWorld world(0);
	SteppingThread thread = bench.thread(world);
	thread.enableForces(false);
	thread.onHapticTick.addDelegate([](const DeviceState&, ist::Wrench& w) { w.force.x = 0.1; });
	thread.run(10);
	return isZero(thread.sentWrench()) && thread.safetyCounts().disabled == 10;
}
}  // namespace

int runSelfTest(const RunArguments& arguments)
{
	auto opened = openWithHand(arguments.uri);
	if (!opened) return fail(opened.error().message);
	VirtualClock virtualClock;
	RealClock realClock;
	const Bench bench{*opened.value(), arguments.realTime ? static_cast<Clock&>(realClock) : virtualClock,
		wallStiffness(opened.value()->info(), arguments.stiffness)};
	const auto notFinite = [](ist::Wrench& w) { w.force.y = std::numeric_limits<double>::quiet_NaN(); };
	const auto throws = [](ist::Wrench&) { throw std::runtime_error("self test"); };
	const std::vector<std::pair<const char*, bool>> results = {{"a round of the hand stays within the limits", staysWithinLimits(bench)},
		{"a wrench that is not finite gives zero", endsInZero(bench, FaultCause::NotFinite, notFinite)},
		{"an exception in a hook gives zero", endsInZero(bench, FaultCause::HookException, throws)},
		{"switched off means zero", obeysTheSwitch(bench)}};
	bench.device.close();
	Report report = newReport();
	report["uri"] = arguments.uri;
	bool ok = true;
	Report& rows = report["checks"] = Report::list();
	for (const auto& [name, passed] : results)
	{
		rows.append({{"check", name}, {"ok", passed}});
		ok = ok && passed;
	}
	report["ok"] = ok;
	print(report, arguments.json);
	return ok ? kGood : kBadInput;
}
}  // namespace devicebridge::tools
