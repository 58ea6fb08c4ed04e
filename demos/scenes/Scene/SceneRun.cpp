// SPDX-License-Identifier: Zlib
#include "demos/scenes/Scene/SceneRun.h"

#include "DeviceBridge/Bullet/BulletHandSource.h"
#include "DeviceBridge/Bullet/BulletWorldCoupling.h"
#include "DeviceBridge/Loop/StopSignals.h"
#include "demos/scenes/Scene/PlayedHand.h"
#include "demos/scenes/Scene/SceneHooks.h"
#include "demos/scenes/Scene/SceneSwitches.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <list>
#include <system_error>
#include <thread>
#include <utility>

using namespace ist;
using namespace devicebridge;

namespace scenes
{
namespace
{
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

/// The hands of a run. Their addresses stay.
using Hands = std::list<PlayedHand>;

/// A world beside the hands: in its own thread in real time, between the ticks in virtual time.
class WorldBeside
{
public:
	WorldBeside(SceneWorld& world, Hands& hands, SceneSwitches& switches, Clock& clock, double rate)
		: m_coupling(world.world()),
		  m_hands(hands),
		  m_switches(switches),
		  m_clock(clock),
		  m_period(1 / rate)
	{
		for (PlayedHand& hand : hands) m_coupling.add(*hand.decoupled);
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
	/// Makes all steps that are due, and one answer of each contact thread.
	void catchUp()
	{
		while (due() <= m_clock.now()) step();
		for (PlayedHand& hand : m_hands) hand.decoupled->serveContacts();
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
		m_switches.applyToWorld();
		m_coupling.step(m_period);
		++m_steps;
	}

	BulletWorldCoupling m_coupling;
	Hands& m_hands;
	SceneSwitches& m_switches;
	Clock& m_clock;
	double m_period;
	std::int64_t m_start = 0, m_steps = 0;
	std::atomic<bool> m_running{true};
	std::thread m_thread;
};

/// A scene on the stage: its world, its hands, and the loops that tick them.
class Performance
{
public:
	Performance(const Scene& scene, const SceneRunOptions& options, SceneWorld& world)
		: m_scene(scene),
		  m_options(options),
		  m_world(world),
		  m_ticks(static_cast<size_t>(std::ceil(scene.duration / kSceneTick)))
	{
		if (options.virtualTime) m_clock = std::make_unique<VirtualClock>();
		else m_clock = std::make_unique<RealClock>();
	}

	std::optional<Error> prepare();
	std::optional<Error> play(SceneOutcome& outcome);

private:
	bool isOneThread() const { return m_scene.topology == SceneTopology::OneThread; }
	void makeSource(PlayedHand& hand);
	std::optional<Error> makeLoop(PlayedHand& hand);
	std::optional<Error> startHelpers();
	void stopHelpers();
	bool report() const;
	Result<bool> performInVirtualTime(const SceneHooks& hooks);
	Result<bool> performInRealTime();
	bool allRecorded() const;

	const Scene& m_scene;
	const SceneRunOptions& m_options;
	SceneWorld& m_world;
	size_t m_ticks;
	std::unique_ptr<Clock> m_clock;
	Hands m_hands;
	std::vector<SteppingThread*> m_loops;  // of one thread: that of the first hand
	std::unique_ptr<SceneSwitches> m_switches;
	std::unique_ptr<WorldBeside> m_beside;
};

std::optional<Error> Performance::prepare()
{
	for (const SceneHand& hand : m_scene.hands)
		if (auto refused = openHand(hand, m_world, *m_clock, m_options.build, m_hands.emplace_back())) return refused;
	size_t number = 0;
	for (PlayedHand& hand : m_hands)
	{
		for (const auto& [named, body] : m_scene.partPairs)
			for (int part = 0; named == number && part < kHandParts; ++part)
				m_world.world().pairFilter().addPair(&hand.parts->body(part), m_world.body(body).body.get());
		++number;
		makeSource(hand);
		if (auto refused = makeLoop(hand)) return refused;
	}
	m_switches = std::make_unique<SceneSwitches>(m_scene, m_world, m_hands);
	if (!isOneThread()) m_beside = std::make_unique<WorldBeside>(m_world, m_hands, *m_switches, *m_clock, m_scene.worldRate);
	return std::nullopt;
}

void Performance::makeSource(PlayedHand& hand)
{
	if (hand.parts)
	{
		hand.source = std::make_unique<BulletHandSource>(m_world.world(), *hand.parts, *hand.device, hand.X_BW);
		return;
	}
	SceneWorld::Body& tool = m_world.body(hand.scene->tool);
	if (isOneThread())
	{
		BulletToolSettings settings;
		settings.gains = hand.gains;
		settings.X_BW = hand.X_BW;
		settings.gravity = hand.scene->toolGravity;
		auto source = std::make_unique<BulletContactSource>(m_world.world(), *tool.body, settings);
		hand.inLoop = source.get();
		hand.source = std::move(source);
		return;
	}
	BulletDecoupledSettings settings;
	settings.gains = hand.gains;
	settings.X_BW = hand.X_BW;
	settings.gravity = hand.scene->toolGravity;
	settings.maxPairs = m_scene.maxPairs;
	settings.topology = m_scene.topology == SceneTopology::InTick ? ContactThreading::InHapticThread
		: m_scene.topology == SceneTopology::LocalModel           ? ContactThreading::InWorldThread
																  : ContactThreading::OwnThread;
	auto source = std::make_unique<BulletDecoupledSource>(*tool.body, tool.tree, *m_clock, settings);
	hand.decoupled = source.get();
	hand.source = std::move(source);
}

std::optional<Error> Performance::makeLoop(PlayedHand& hand)
{
	SteppingSettings settings;
	settings.lockMemory = true;  // the hand is the purpose of this program
	hand.thread = std::make_unique<SteppingThread>(*hand.device, *hand.source, *m_clock, settings);
	hand.recorder = std::make_unique<TickRecorder>(*hand.thread, *hand.device, *m_clock, hand.X_BW, m_ticks, hand.decoupled);
	if (m_scene.topology == SceneTopology::ForceThread)
	{
		hand.law = std::make_unique<ThreadedForceLaw>(hand.coupling);
		hand.thread->setForceLaw(hand.law.get());
	}
	if (!isOneThread() || m_loops.empty()) m_loops.push_back(hand.thread.get());
	else if (const char* refused = m_loops.front()->addHand(*hand.thread); refused[0] != '\0') return at(hand.scene->place, refused);
	return std::nullopt;
}

/// Starts the threads of contacts and force laws, in real time.
std::optional<Error> Performance::startHelpers()
{
	if (m_options.virtualTime) return std::nullopt;
	for (PlayedHand& hand : m_hands)
	{
		const bool ownThread = hand.decoupled && hand.decoupled->topology() == ContactThreading::OwnThread;
		if (ownThread && !hand.decoupled->startContactThread()) return Error{"the thread of the contacts cannot be started"};
		if (hand.law && !hand.law->start()) return Error{"the thread of the force law cannot be started"};
	}
	return std::nullopt;
}

void Performance::stopHelpers()
{
	for (PlayedHand& hand : m_hands)
	{
		if (hand.law) hand.law->stop();
		if (hand.decoupled) hand.decoupled->stopContactThread();
	}
}

bool Performance::allRecorded() const
{
	return std::all_of(m_hands.begin(), m_hands.end(), [&](const PlayedHand& hand) { return hand.recorder->size() >= m_ticks; });
}

bool Performance::report() const
{
	size_t least = m_ticks;
	for (const PlayedHand& hand : m_hands) least = std::min(least, hand.recorder->size());
	return !m_options.build.progress || m_options.build.progress("hand", static_cast<double>(least) / static_cast<double>(m_ticks));
}

/// Runs all ticks. The value is false when a stop was requested.
Result<bool> Performance::performInVirtualTime(const SceneHooks& hooks)
{
	for (size_t i = 0; i < m_ticks && !hooks.stopWanted(); ++i)
	{
		if (m_beside) m_beside->catchUp();
		for (PlayedHand& hand : m_hands)
			if (hand.law) hand.law->serve();
		for (SteppingThread* loop : m_loops)
			if (!loop->run(1)) return Error{loop->refusal()};
		if (i % 250 == 0 && !report()) return false;
	}
	return true;
}

Result<bool> Performance::performInRealTime()
{
	const std::int64_t end = m_clock->now() + static_cast<std::int64_t>(1e9 * (m_scene.duration + 5));
	std::list<StopSignals> signals;
	for (SteppingThread* loop : m_loops) signals.emplace_back(*loop);
	if (m_beside && !m_beside->start()) return Error{"the thread of the world cannot be started"};
	const auto stop = [&] {
		for (SteppingThread* loop : m_loops) loop->stop();
		if (m_beside) m_beside->stop();
	};
	for (SteppingThread* loop : m_loops)
	{
		if (loop->start()) continue;
		const std::string why = loop->refusal();
		stop();
		return Error{"the thread of the hand cannot be started: " + why};
	}
	const auto allRun = [&] { return std::all_of(m_loops.begin(), m_loops.end(), [](auto* loop) { return loop->running(); }); };
	bool wanted = true;
	while (wanted && allRun() && !allRecorded() && m_clock->now() < end)
	{
		std::this_thread::sleep_for(std::chrono::milliseconds(50));
		wanted = report();
	}
	stop();
	return wanted && StopSignals::caught() == 0;
}

std::optional<Error> Performance::play(SceneOutcome& outcome)
{
	SceneHooks hooks(m_scene, m_world, m_hands, *m_switches, m_clock->now(), m_ticks);
	SteppingThread& first = *m_hands.front().thread;
	if (m_options.listener)
		first.onHapticTick.addDelegate([&](const DeviceState&, const Wrench&) {
			if (!m_options.listener(first, m_world)) hooks.stop();
		});
	std::optional<Error> refused = startHelpers();
	const Result<bool> performed = refused ? *refused : m_options.virtualTime ? performInVirtualTime(hooks) : performInRealTime();
	stopHelpers();
	if (!performed) return performed.error();
	outcome.interrupted = !performed.value();
	outcome.stopped = hooks.stopWanted();
	for (PlayedHand& hand : m_hands) outcome.hands.push_back(runOf(hand, m_ticks, m_options.virtualTime));
	for (const SceneHandRun& run : outcome.hands)
		outcome.cutShort = outcome.cutShort || (run.cutShort && !outcome.interrupted && !outcome.stopped);
	hooks.finish(outcome);
	return std::nullopt;
}
}  // namespace

bool SceneOutcome::ok() const
{
	for (const SceneHandRun& hand : hands)
		if (!hand.finite || hand.faulted) return false;
	return !hands.empty() && !cutShort && unwritten.empty();
}

Result<SceneOutcome> runScene(const Scene& scene, const SceneRunOptions& options, std::unique_ptr<SceneWorld>* world)
{
	if (scene.hands.empty())
		return at(scene.handPlace, "is missing: a session needs one, such as {\"device\": \"sim:inverse3\", \"tool\": \"NAME OF A BODY\"}");
	if (auto refused = checkRecordings(scene)) return *refused;
	Result<std::unique_ptr<SceneWorld>> made = SceneWorld::make(scene, scene.topology == SceneTopology::OneThread, options.build);
	if (!made) return made.error();
	SceneOutcome outcome;
	outcome.scene = scene;
	outcome.virtualTime = options.virtualTime;
	{
		Performance performance(outcome.scene, options, *made.value());
		if (auto refused = performance.prepare()) return *refused;
		if (auto refused = performance.play(outcome)) return *refused;
	}
	if (world) *world = std::move(made).value();
	return outcome;
}
}  // namespace scenes
