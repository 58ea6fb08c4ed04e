// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Asset/AtomicFile.h"
#include "DeviceBridge/Decorators/RecordingDevice.h"
#include "DeviceBridge/Drivers/Replay/ReplayDevice.h"
#include "DeviceBridge/Hand/HandRecording.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "DeviceBridge/Loop/StopSignals.h"
#include "DeviceBridge/Tools/Commands.h"
#include "DeviceBridge/Tools/OpenedDevice.h"
#include "DeviceBridge/Tools/WallWorld.h"

namespace devicebridge::tools
{
namespace
{
constexpr std::int64_t kLook = 20'000'000;  // [ns]

/// Runs for the requested number of ticks, or until a signal.
void runFor(SteppingThread& thread, Clock& clock, std::int64_t ticks, bool realTime)
{
	const StopSignals stop(thread);
	if (!realTime)
	{
		for (std::int64_t done = 0; done < ticks && !StopSignals::caught(); done += 100)
			thread.run(std::min<std::int64_t>(100, ticks - done));
		return;
	}
	if (!thread.start()) return;
	while (thread.running() && static_cast<std::int64_t>(thread.ticks()) < ticks) clock.sleepUntil(clock.now() + kLook);
	thread.stop();
}

void describe(Report& report, const SteppingThread& thread)
{
	const SafetyCounts c = thread.safetyCounts();
	report["ticks"] = thread.ticks();
	report["overruns"] = thread.overruns();
	report["device_errors"] = thread.deviceErrors();
	report["faults"] = thread.faults();
	report["safety"] = {{"not_finite", c.notFinite}, {"faulted", c.faulted}, {"aged", c.aged}, {"disabled", c.disabled},
		{"ramped", c.ramped}, {"start_inside", c.startInside}, {"not_actuated", c.notActuated}, {"passivity", c.passivity},
		{"slewed", c.slewed}, {"saturated", c.saturated}, {"heat", c.heat}, {"over_speed", c.overSpeed}};
	const EnergyLog e = thread.energy();
	report["energy"] = {{"stored", e.stored}, {"generated", e.generated}, {"dissipated", e.dissipated}};
}

/// Why the results could not be written; checked before the recording begins.
std::optional<ist::Error> whyNotKept(const RunArguments& arguments)
{
	if (auto obstacle = ist::whyNotWritable(arguments.output)) return obstacle;
	if (arguments.hand.empty()) return std::nullopt;
	if (ist::isSameFile(arguments.output, arguments.hand))
		return ist::Error{"\"" + arguments.hand + "\" is to hold the recording and the hand; name two files"};
	return ist::whyNotWritable(arguments.hand);
}

/// Writes the motion of the hand if it was requested.
std::optional<ist::Error> writeHand(const Recording& recording, const std::string& path, Report& report)
{
	if (path.empty()) return std::nullopt;
	const ist::Result<HandMotion> motion = handMotionOf(recording);
	if (!motion) return motion.error();
	report["hand"] = path;
	report["hand_frames"] = motion.value().frames.size();
	return saveHandMotion(motion.value(), path);
}
}  // namespace

int runRecord(const RunArguments& arguments)
{
	if (const auto obstacle = whyNotKept(arguments)) return fail(obstacle->message);
	auto opened = openWithHand(arguments.uri);
	if (!opened) return fail(opened.error().message);
	if (!arguments.hand.empty() && !(opened.value()->info().sensed & kHandJointsSensed))
		return fail(arguments.uri + " senses no joints of a hand: leave --hand out");
	const auto ticks = static_cast<std::int64_t>(1000 * arguments.seconds);
	RecordingDevice device(std::move(opened).value(), static_cast<std::size_t>(ticks));
	WallWorld world(wallStiffness(device.info(), arguments.stiffness));
	VirtualClock virtualClock;
	RealClock realClock;
	Clock& clock = arguments.realTime ? static_cast<Clock&>(realClock) : virtualClock;
	Report report = newReport();
	{
		SteppingSettings settings;
		settings.lockMemory = arguments.realTime;
		SteppingThread thread(device, world, clock, settings);
		runFor(thread, clock, ticks, arguments.realTime);
		describe(report, thread);
	}
	device.close();
	const auto saved = saveRecording(device.recording(), arguments.output);
	if (!saved) return fail(saved.error().message);
	report["file"] = arguments.output;
	report["bytes"] = saved.value();
	if (auto error = writeHand(device.recording(), arguments.hand, report)) return fail(error->message);
	print(report, arguments.json);
	return StopSignals::caught() ? kInterrupted : kGood;
}

int runReplay(const RunArguments& arguments)
{
	auto recording = loadRecording(arguments.uri);
	if (!recording) return fail(recording.error().message);
	RecordedClock clock(recording.value());
	ReplayDevice device(std::move(recording).value());
	device.open();
	WallWorld world(wallStiffness(device.info(), arguments.stiffness));
	Report report = newReport();
	SteppingThread thread(device, world, clock);
	thread.run(static_cast<std::int64_t>(device.length()));
	describe(report, thread);
	report["mismatches"] = device.mismatches();
	if (device.mismatches()) report["first_mismatch"] = device.firstMismatch();
	else report["first_mismatch"] = nullptr;
	report["ok"] = device.mismatches() == 0;
	print(report, arguments.json);
	return device.mismatches() == 0 ? kGood : kBadInput;
}
}  // namespace devicebridge::tools
