// SPDX-License-Identifier: Zlib
#include "demos/scenes/Scene/PlayedHand.h"

#include "BulletISTCollision/Core/Base/ThreadTime.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"

#include <cmath>
#include <cstdio>
#include <utility>

using namespace ist;
using namespace devicebridge;

namespace scenes
{
namespace
{
constexpr double kFrozen = 0.5;     // time after which a live hand that does not tremble is lost [s]
constexpr double kFirstSample = 5;  // longest time until a tracked hand is seen with all its joints [s]

Error at(const std::string& place, const std::string& what) { return {place + ": " + what}; }

void apply(const SceneCoupling& wanted, CouplingGains& gains)
{
	const auto take = [](double from, double& to) {
		if (from >= 0) to = from;
	};
	take(wanted.stiffness, gains.stiffness);
	take(wanted.angularStiffness, gains.angularStiffness);
	take(wanted.damping, gains.damping);
	take(wanted.angularDamping, gains.angularDamping);
	take(wanted.maxForce, gains.maxForce);
	take(wanted.maxTorque, gains.maxTorque);
	gains.isStatic = wanted.isStatic;
	gains.softContact = wanted.softContact;
}

/// Lets the hand of a simulated device follow the path of the file, which must have a frame.
void followPath(const SceneHand& scene, const Pose& X_MP, const Pose& X_BW, SimulatedDevice& device)
{
	std::vector<HandKeyFrame> frames;
	for (const SceneKeyFrame& frame : scene.path) frames.push_back({frame.time, inverse(X_BW) * frame.X_BM * X_MP});
	device.place(frames.front().pose);
	device.setHand(handThrough(std::move(frames)));
}

void printAssumed(const std::string& assumed) { std::fprintf(stderr, "%s\n", assumed.c_str()); }

/// Presses buttons as the path of the file says.
class ScriptedButtons final : public DeviceDecorator
{
public:
	ScriptedButtons(std::unique_ptr<Device> device, const std::vector<SceneKeyFrame>& path) : DeviceDecorator(std::move(device))
	{
		for (const SceneKeyFrame& frame : path) m_frames.push_back({static_cast<std::int64_t>(1e9 * frame.time), frame.buttons});
	}
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override
	{
		const DeviceStatus status = m_inner->read(now, state);
		if (m_start < 0) m_start = now;
		while (m_next < m_frames.size() && now - m_start >= m_frames[m_next].first) m_held = m_frames[m_next++].second;
		if (status == DeviceStatus::Ok) state.buttons |= m_held;
		return status;
	}

private:
	std::vector<std::pair<std::int64_t, std::uint32_t>> m_frames;  // time [ns], and the buttons held from then on
	std::int64_t m_start = -1;
	size_t m_next = 0;
	std::uint32_t m_held = 0;
};

/// A simulated device with options, whose hand follows the path.
std::optional<Error> openWithOptions(const SceneHand& scene, const Pose& X_MP, PlayedHand& hand)
{
	Result<std::unique_ptr<Device>> opened = DeviceRegistry().open(scene.device);
	if (!opened) return at(scene.devicePlace, opened.error().message);
	hand.device = std::make_unique<TimedDevice>(std::move(opened).value());
	if (hand.device->info().scale != 1)
		return at(scene.devicePlace, "a simulated device with a scale follows no path: leave out scale, or the path");
	Device* innermost = hand.device.get();
	while (auto* decorator = dynamic_cast<DeviceDecorator*>(innermost)) innermost = &decorator->inner();
	auto* simulated = dynamic_cast<SimulatedDevice*>(innermost);
	if (!simulated) return at(scene.devicePlace, "a simulated device with these options follows no path: " + scene.device);
	if (simulated->isLed()) return at(scene.devicePlace, "a simulated device that presses follows no path: leave out press, or the path");
	followPath(scene, X_MP, hand.X_BW, *simulated);
	hand.device = std::make_unique<TimedDevice>(std::make_unique<ScriptedButtons>(std::move(hand.device), scene.path));
	hand.gains = gainsForDevice(hand.device->info(), kSceneTick, printAssumed);
	return std::nullopt;
}

std::optional<Error> openDevice(const SceneHand& scene, const Pose& X_MP, PlayedHand& hand)
{
	const std::string prefix = "sim:";
	const bool isSimulated = scene.device.compare(0, prefix.size(), prefix) == 0;
	if (isSimulated && !scene.parts && !scene.path.empty() && scene.device.find('?') != std::string::npos)
		return openWithOptions(scene, X_MP, hand);
	if (scene.parts || !isSimulated || scene.device.find('?') != std::string::npos)
	{
		if (!scene.path.empty())
			return at(scene.devicePlace,
				"only a simulated device follows the path of its hand, not " + scene.device + ": leave the path out, and set `duration`");
		Result<std::unique_ptr<Device>> opened = DeviceRegistry().open(scene.device);
		if (!opened) return at(scene.devicePlace, opened.error().message);
		hand.device = std::make_unique<TimedDevice>(std::move(opened).value());
		if (!scene.parts) hand.gains = gainsForDevice(hand.device->info(), kSceneTick, printAssumed);
		return std::nullopt;
	}
	const Result<SimulatedProfile> profile = simulatedProfile(scene.device.substr(prefix.size()));
	if (!profile) return at(scene.devicePlace, profile.error().message);
	auto device = std::make_unique<SimulatedDevice>(profile.value());
	if (!scene.path.empty()) followPath(scene, X_MP, hand.X_BW, *device);
	device->open();
	hand.gains = gainsForDevice(profile.value().info, kSceneTick, printAssumed);
	hand.device = std::make_unique<TimedDevice>(std::make_unique<ScriptedButtons>(std::move(device), scene.path));
	return std::nullopt;
}

/// Waits for a sample in which every joint is tracked. In World.
Result<HandState> firstSample(const SceneHand& scene, PlayedHand& hand, Clock& clock)
{
	const std::int64_t end = clock.now() + static_cast<std::int64_t>(1e9 * kFirstSample);
	DeviceState state;
	HandState joints;
	for (bool seen = false; clock.now() < end; clock.sleepUntil(clock.now() + static_cast<std::int64_t>(1e9 * kSceneTick)))
	{
		seen = hand.device->read(clock.now(), state) == DeviceStatus::Ok && hand.device->readHand(joints);
		for (const HandJoint& joint : joints.joints) seen = seen && joint.tracked;
		if (!seen) continue;
		moveHand(joints, hand.X_BW);
		return joints;
	}
	const bool senses = (hand.device->info().sensed & kHandJointsSensed) != 0;
	return at(scene.devicePlace,
		senses ? "no sample with all joints of the hand came within 5 s: hold it where it is seen"
			   : "senses no joints of a hand, which parts want; devices that do: motion:, glove:, openxr:hand/right");
}

/// Makes the parts of a tracked hand at its pose. The model takes seconds, so a recording begins anew afterwards.
std::optional<Error> makeParts(const SceneHand& scene, SceneWorld& world, Clock& clock, const SceneBuildOptions& build, PlayedHand& hand)
{
	const Result<HandState> measured = firstSample(scene, hand, clock);
	if (!measured) return measured.error();
	const Result<HandShape> shape = measureHand(measured.value());
	if (!shape) return at(scene.devicePlace, shape.error().message);
	const Result<std::shared_ptr<const HandModel>> model = buildHandModel(
		shape.value(), {scene.parts->spheres, build.cache, 0, build.progress});
	if (!model) return Error{scene.place + ": " + model.error().message, model.error().cancelled};
	hand.device->close();
	if (const DeviceStatus status = hand.device->open(); status != DeviceStatus::Ok) return at(scene.devicePlace, describe(status));
	const Result<HandState> start = firstSample(scene, hand, clock);
	if (!start) return start.error();
	BulletHandSettings settings;
	settings.friction = scene.parts->friction;
	if (scene.device.compare(0, 7, "motion:") != 0) settings.tracking.frozenAfter = kFrozen;  // a scripted hand may rest
	Result<std::unique_ptr<BulletHand>> made = BulletHand::create(world.world(), model.value(), start.value(), settings);
	if (!made) return at(scene.devicePlace, made.error().message);
	hand.parts = std::move(made).value();
	return std::nullopt;
}
}  // namespace

DeviceStatus TimedDevice::read(std::int64_t now, DeviceState& state) noexcept
{
	const double begin = ist::threadMicroseconds();
	const DeviceStatus status = m_inner->read(now, state);
	m_used += ist::threadMicroseconds() - begin;
	return status;
}

PlayedHand::~PlayedHand()
{
	recorder.reset();
	thread.reset();
	if (device) device->close();
}

std::optional<Error> openHand(const SceneHand& scene, SceneWorld& world, Clock& clock, const SceneBuildOptions& build, PlayedHand& hand)
{
	hand.scene = &scene;
	const Pose X_MP = scene.parts ? Pose() : world.body(scene.tool).X_MP;
	if (scene.X_BW) hand.X_BW = *scene.X_BW;
	else if (!scene.path.empty()) hand.X_BW.translation = (scene.path.front().X_BM * X_MP).translation;
	if (auto refused = openDevice(scene, X_MP, hand)) return refused;
	apply(scene.coupling, hand.gains);
	if (!scene.parts && whyNotMoved(hand.gains)[0] != '\0')
		return at(scene.place,
			"the gains of its coupling are zero, so it would move nothing and feel nothing: leave stiffness, damping, maxForce and "
			"maxTorque out, and they are what the device bears");
	return scene.parts ? makeParts(scene, world, clock, build, hand) : std::nullopt;
}

SceneHandRun runOf(PlayedHand& hand, size_t ticks, bool virtualTime)
{
	const SteppingThread& thread = *hand.thread;
	SceneHandRun run;
	run.name = hand.scene->name;
	run.device = hand.device->info().model;
	run.begun = hand.recorder->begun();
	run.ticks = hand.recorder->take();
	run.cutShort = run.ticks.size() < ticks;
	run.overruns = thread.overruns();
	run.deviceErrors = thread.deviceErrors();
	run.safety = thread.safetyCounts();
	run.faulted = thread.faulted();
	run.scheduling = virtualTime ? "virtual time, on the caller's thread" : thread.scheduling();
	run.memory = thread.memory();
	run.finite = !run.ticks.empty();
	for (const SceneTick& tick : run.ticks)
	{
		run.finite = run.finite && isRigid(tick.tool) && isFinite(tick.wrench) && std::isfinite(tick.volume);
		run.maxForce = std::max(run.maxForce, norm(tick.wrench.force));
	}
	if (hand.decoupled)
	{
		run.refusedQueries = hand.decoupled->statistics().refusedQueries;
		run.worldSteps = hand.decoupled->statistics().worldSteps;
	}
	return run;
}

TickRecorder::TickRecorder(
	SteppingThread& thread, const TimedDevice& device, Clock& clock, const Pose& X_BW, size_t capacity, const BulletDecoupledSource* source)
	: m_thread(thread),
	  m_clock(clock),
	  m_device(device),
	  m_X_BW(X_BW),
	  m_source(source)
{
	m_ticks.reserve(capacity);
	thread.onTransform.addDelegate([this](const DeviceState& state) { begin(state); });
	thread.onHapticTick.addDelegate([this](const DeviceState&, const Wrench&) { end(); });
}

std::vector<SceneTick> TickRecorder::take()
{
	closeLast();
	return std::move(m_ticks);
}

void TickRecorder::closeLast()
{
	if (m_open && !m_ticks.empty()) m_ticks.back().wrench = m_thread.sentWrench();
	m_open = false;
}

void TickRecorder::begin(const DeviceState& state)
{
	closeLast();
	const std::int64_t now = m_clock.now();
	const double used = ist::threadMicroseconds();
	const double inDevice = m_device.used();
	if (m_first < 0) m_first = m_last = now, m_used = used, m_usedInDevice = inDevice;
	m_next = {};
	m_next.time = 1e-9 * static_cast<double>(now - m_first);
	m_next.period = 1e-9 * static_cast<double>(now - m_last);
	m_next.threadMicroseconds = used - m_used;
	m_next.deviceMicroseconds = inDevice - m_usedInDevice;
	m_next.hand = state.X_WH;
	m_last = now;
	m_used = used;
	m_usedInDevice = inDevice;
}

void TickRecorder::end()
{
	if (m_ticks.size() == m_ticks.capacity()) return;
	const ToolStep& step = m_thread.step();
	m_next.tool = m_X_BW * step.tool.X_WT;
	m_next.volume = step.overlapVolume;
	m_next.pairs = step.pairs;
	m_next.queryMicroseconds = step.queryMicroseconds;
	m_next.contacts = step.contactCount;
	if (m_source && m_source->topology() == ContactThreading::OwnThread) m_next.answer = m_source->lastAnswer();
	m_ticks.push_back(m_next);
	m_open = true;
	m_count.store(m_ticks.size(), std::memory_order_release);
}
}  // namespace scenes
