// SPDX-License-Identifier: Zlib
#include "demos/scenes/Scene/SceneRun.h"

#include "BulletISTCollision/Core/Base/ThreadTime.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "DeviceBridge/Bullet/BulletContactSource.h"
#include "DeviceBridge/Bullet/BulletWorldCoupling.h"
#include "DeviceBridge/Decorators/DeviceDecorator.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "DeviceBridge/Loop/StopSignals.h"
#include "DeviceBridge/Loop/ThreadedForceLaw.h"
#include "demos/scenes/Scene/SceneHooks.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>
#include <thread>
#include <utility>

using namespace ist;
using namespace devicebridge;

namespace scenes
{
namespace
{
constexpr double kTick = 1e-3;  // [s]

/// Measures the processor time of a device's calls.
class TimedDevice final : public DeviceDecorator
{
public:
	using DeviceDecorator::DeviceDecorator;
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override
	{
		const double begin = ist::threadMicroseconds();
		const DeviceStatus status = m_inner->read(now, state);
		m_used += ist::threadMicroseconds() - begin;
		return status;
	}
	/// Processor time so far [us].
	double used() const { return m_used; }

private:
	double m_used = 0;
};

/// The opened device of a scene, and its connection to the world.
struct Hand
{
	std::unique_ptr<TimedDevice> device;
	std::unique_ptr<Clock> clock;
	Pose X_BW;
	CouplingGains gains;
};

ist::Error at(const std::string& place, const std::string& what) { return {place + ": " + what}; }

/// Checks the recordings before the run, so that an error does not appear only after it.
std::optional<Error> checkRecordings(const Scene& scene)
{
	for (const SceneHook& hook : scene.hooks)
	{
		const std::filesystem::path folder = std::filesystem::path(hook.file).parent_path();
		std::error_code failed;
		if (folder.empty() || std::filesystem::is_directory(folder, failed)) continue;
		return at(hook.place, "cannot write the recording " + hook.file + ": there is no folder " + folder.string());
	}
	return std::nullopt;
}

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

std::vector<HandKeyFrame> framesInW(const Scene& scene, const Pose& X_MP, const Pose& X_BW)
{
	std::vector<HandKeyFrame> frames;
	for (const SceneKeyFrame& frame : scene.path) frames.push_back({frame.time, inverse(X_BW) * frame.X_BM * X_MP});
	return frames;
}

void printAssumed(const std::string& assumed) { std::fprintf(stderr, "%s\n", assumed.c_str()); }

/// Opens the device of a scene. A simulated hand follows the path of the file; any other device moves by itself.
std::optional<Error> openDevice(const Scene& scene, const Pose& X_MP, Hand& hand)
{
	const std::string prefix = "sim:";
	if (scene.device.compare(0, prefix.size(), prefix) != 0 || scene.device.find('?') != std::string::npos)
	{
		if (!scene.path.empty())
			return at(scene.devicePlace, "only a simulated device without options follows hand.path, not " + scene.device);
		Result<std::unique_ptr<Device>> opened = DeviceRegistry().open(scene.device);
		if (!opened) return at(scene.devicePlace, opened.error().message);
		hand.device = std::make_unique<TimedDevice>(std::move(opened).value());
		hand.gains = gainsForDevice(hand.device->info(), kTick, printAssumed);
		return std::nullopt;
	}
	const Result<SimulatedProfile> profile = simulatedProfile(scene.device.substr(prefix.size()));
	if (!profile) return at(scene.devicePlace, profile.error().message);
	auto device = std::make_unique<SimulatedDevice>(profile.value());
	if (!scene.path.empty())
	{
		std::vector<HandKeyFrame> frames = framesInW(scene, X_MP, hand.X_BW);
		device->place(frames.front().pose);
		device->setHand(handThrough(std::move(frames)));
	}
	device->open();
	hand.gains = gainsForDevice(profile.value().info, kTick, printAssumed);
	hand.device = std::make_unique<TimedDevice>(std::move(device));
	return std::nullopt;
}

/// Writes one row per tick into preallocated memory.
class TickRecorder
{
public:
	TickRecorder(SteppingThread& thread, const Hand& hand, size_t capacity, const BulletDecoupledSource* source)
		: m_thread(thread),
		  m_clock(*hand.clock),
		  m_device(*hand.device),
		  m_X_BW(hand.X_BW),
		  m_source(source)
	{
		m_ticks.reserve(capacity);
		thread.onTransform.addDelegate([this](const DeviceState& state) { begin(state); });
		thread.onHapticTick.addDelegate([this](const DeviceState&, const Wrench&) { end(); });
	}
	size_t size() const { return m_count.load(std::memory_order_acquire); }
	std::vector<SceneTick> take()
	{
		closeLast();
		return std::move(m_ticks);
	}

private:
	void closeLast()
	{
		if (m_open && !m_ticks.empty()) m_ticks.back().wrench = m_thread.sentWrench();
		m_open = false;
	}

	void begin(const DeviceState& state)
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

	void end()
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

	SteppingThread& m_thread;
	Clock& m_clock;
	const TimedDevice& m_device;
	Pose m_X_BW;
	const BulletDecoupledSource* m_source;
	std::vector<SceneTick> m_ticks;
	SceneTick m_next;
	std::atomic<size_t> m_count{0};
	std::int64_t m_first = -1, m_last = -1;
	double m_used = 0, m_usedInDevice = 0;
	bool m_open = false;
};

/// A world beside the hand: in its own thread in real time, between the ticks in virtual time.
class WorldBeside
{
public:
	WorldBeside(SceneWorld& world, BulletDecoupledSource& source, Clock& clock, double rate)
		: m_coupling(world.world()),
		  m_source(source),
		  m_clock(clock),
		  m_period(1 / rate)
	{
		m_coupling.add(source);
		m_coupling.show(m_period);
		m_start = clock.now();
	}
	~WorldBeside() { stop(); }

	/// Returns false when no thread can be started.
	bool start()
	{
		try
		{
			m_thread = std::thread([this] { loop(); });
		}
		catch (const std::system_error&)
		{
			return false;
		}
		return true;
	}
	void stop()
	{
		m_running = false;
		if (m_thread.joinable()) m_thread.join();
	}
	/// Makes all steps that are due, and one answer of the contact thread.
	void catchUp()
	{
		while (due() <= m_clock.now()) step();
		m_source.serveContacts();
	}

private:
	void loop()
	{
		while (m_running)
		{
			m_clock.sleepUntil(due());
			step();
		}
	}
	std::int64_t due() const { return m_start + static_cast<std::int64_t>(1e9 * m_period * static_cast<double>(m_steps + 1)); }
	void step()
	{
		m_coupling.step(m_period);
		++m_steps;
	}

	BulletWorldCoupling m_coupling;
	BulletDecoupledSource& m_source;
	Clock& m_clock;
	double m_period;
	std::int64_t m_start = 0, m_steps = 0;
	std::atomic<bool> m_running{true};
	std::thread m_thread;
};

struct Stage
{
	const Scene& scene;
	const SceneRunOptions& options;
	SceneWorld& world;
	Hand& hand;
	size_t ticks;
};

/// Runs all ticks. The value is false when a stop was requested.
Result<bool> perform(const Stage& stage, SteppingThread& thread, const TickRecorder& recorder, const SceneHooks& hooks, WorldBeside* beside,
	ThreadedForceLaw* law)
{
	const auto report = [&] {
		const double fraction = static_cast<double>(recorder.size()) / static_cast<double>(stage.ticks);
		return !stage.options.build.progress || stage.options.build.progress("hand", fraction);
	};
	if (stage.options.virtualTime)
	{
		for (size_t i = 0; i < stage.ticks && !hooks.stopWanted(); ++i)
		{
			if (beside) beside->catchUp();
			if (law) law->serve();
			if (!thread.run(1)) return Error{thread.refusal()};
			if (i % 250 == 0 && !report()) return false;
		}
		return true;
	}
	const std::int64_t end = stage.hand.clock->now() + static_cast<std::int64_t>(1e9 * (stage.scene.duration + 5));
	const StopSignals signals(thread);
	if (beside && !beside->start()) return Error{"the thread of the world cannot be started"};
	if (!thread.start())
	{
		if (beside) beside->stop();
		return Error{std::string("the thread of the hand cannot be started: ") + thread.refusal()};
	}
	bool wanted = true;
	while (wanted && thread.running() && recorder.size() < stage.ticks && stage.hand.clock->now() < end)
	{
		std::this_thread::sleep_for(std::chrono::milliseconds(50));
		wanted = report();
	}
	thread.stop();
	if (beside) beside->stop();
	return wanted && StopSignals::caught() == 0;
}

void keep(const SteppingThread& thread, TickRecorder& recorder, const SceneHooks& hooks, bool virtualTime, SceneOutcome& outcome)
{
	outcome.ticks = recorder.take();
	outcome.stopped = hooks.stopWanted();
	outcome.overruns = thread.overruns();
	outcome.deviceErrors = thread.deviceErrors();
	outcome.safety = thread.safetyCounts();
	outcome.faulted = thread.faulted();
	outcome.scheduling = virtualTime ? "virtual time, on the caller's thread" : thread.scheduling();
	outcome.memory = thread.memory();
	outcome.finite = !outcome.ticks.empty();
	for (const SceneTick& tick : outcome.ticks)
	{
		outcome.finite = outcome.finite && isRigid(tick.tool) && isFinite(tick.wrench) && std::isfinite(tick.volume);
		outcome.maxForce = std::max(outcome.maxForce, norm(tick.wrench.force));
	}
}

std::optional<Error> play(const Stage& stage, ContactSource& source, BulletDecoupledSource* decoupled, SceneOutcome& outcome)
{
	SteppingSettings settings;
	settings.lockMemory = true;  // the hand is the purpose of this program
	SteppingThread thread(*stage.hand.device, source, *stage.hand.clock, settings);
	TickRecorder recorder(thread, stage.hand, stage.ticks, decoupled);
	SceneHooks hooks(stage.scene, stage.world, stage.hand.X_BW, thread, stage.hand.clock->now(), stage.ticks);
	if (stage.options.listener)
		thread.onHapticTick.addDelegate([&](const DeviceState&, const Wrench&) {
			if (!stage.options.listener(thread, stage.world)) hooks.stop();
		});
	std::unique_ptr<WorldBeside> beside;
	if (decoupled) beside = std::make_unique<WorldBeside>(stage.world, *decoupled, *stage.hand.clock, stage.scene.worldRate);
	const bool ownThread = decoupled && decoupled->topology() == ContactThreading::OwnThread && !stage.options.virtualTime;
	if (ownThread && !decoupled->startContactThread()) return Error{"the thread of the contacts cannot be started"};
	CouplingForceLaw coupling;
	ThreadedForceLaw law(coupling);
	const bool forceThread = stage.scene.topology == SceneTopology::ForceThread;
	if (forceThread) thread.setForceLaw(&law);
	if (forceThread && !stage.options.virtualTime && !law.start()) return Error{"the thread of the force law cannot be started"};
	const Result<bool> performed = perform(stage, thread, recorder, hooks, beside.get(), forceThread ? &law : nullptr);
	law.stop();
	if (ownThread) decoupled->stopContactThread();
	if (!performed) return performed.error();
	outcome.interrupted = !performed.value();
	keep(thread, recorder, hooks, stage.options.virtualTime, outcome);
	outcome.cutShort = !outcome.interrupted && !outcome.stopped && outcome.ticks.size() < stage.ticks;
	if (decoupled)
	{
		outcome.refusedQueries = decoupled->statistics().refusedQueries;
		outcome.worldSteps = decoupled->statistics().worldSteps;
	}
	hooks.finish(outcome);
	return std::nullopt;
}

std::optional<Error> playOneThread(const Stage& stage, SceneOutcome& outcome)
{
	BulletToolSettings settings;
	settings.gains = stage.hand.gains;
	settings.X_BW = stage.hand.X_BW;
	settings.gravity = stage.scene.toolGravity;
	BulletContactSource source(stage.world.world(), *stage.world.body(stage.scene.tool).body, settings);
	return play(stage, source, nullptr, outcome);
}

std::optional<Error> playDecoupled(const Stage& stage, SceneOutcome& outcome)
{
	BulletDecoupledSettings settings;
	settings.gains = stage.hand.gains;
	settings.X_BW = stage.hand.X_BW;
	settings.gravity = stage.scene.toolGravity;
	settings.maxPairs = stage.scene.maxPairs;
	settings.topology = stage.scene.topology == SceneTopology::InTick ? ContactThreading::InHapticThread
		: stage.scene.topology == SceneTopology::LocalModel           ? ContactThreading::InWorldThread
																	  : ContactThreading::OwnThread;
	SceneWorld::Body& tool = stage.world.body(stage.scene.tool);
	BulletDecoupledSource source(*tool.body, tool.tree, *stage.hand.clock, settings);
	return play(stage, source, &source, outcome);
}
}  // namespace

Result<SceneOutcome> runScene(const Scene& scene, const SceneRunOptions& options, std::unique_ptr<SceneWorld>* world)
{
	if (!scene.hasHand) return at(scene.handPlace, "is missing: a session needs one");
	if (auto refused = checkRecordings(scene)) return *refused;
	const bool oneThread = scene.topology == SceneTopology::OneThread;
	Result<std::unique_ptr<SceneWorld>> made = SceneWorld::make(scene, oneThread, options.build);
	if (!made) return made.error();
	SceneWorld& bodies = *made.value();
	SceneWorld::Body& tool = bodies.body(scene.tool);

	Hand hand;
	if (options.virtualTime) hand.clock = std::make_unique<VirtualClock>();
	else hand.clock = std::make_unique<RealClock>();
	if (scene.X_BW) hand.X_BW = *scene.X_BW;
	else if (!scene.path.empty()) hand.X_BW.translation = (scene.path.front().X_BM * tool.X_MP).translation;
	if (auto refused = openDevice(scene, tool.X_MP, hand)) return *refused;
	apply(scene.coupling, hand.gains);

	SceneOutcome outcome;
	outcome.scene = scene;
	outcome.virtualTime = options.virtualTime;
	outcome.device = hand.device->info().model;
	const Stage stage{scene, options, bodies, hand, static_cast<size_t>(std::ceil(scene.duration / kTick))};
	const auto refused = oneThread ? playOneThread(stage, outcome) : playDecoupled(stage, outcome);
	hand.device->close();
	if (refused) return *refused;
	if (world) *world = std::move(made).value();
	return outcome;
}
}  // namespace scenes
