// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Loop/SteppingThread.h"
#include "demos/scenes/Scene/SceneSwitches.h"

#include <list>

namespace scenes
{
/// The hooks of a scene file, connected to the loops of its hands. All memory is allocated before the first tick. Each hand has its own
/// counters and rows, because each may tick on a thread of its own.
class SceneHooks
{
public:
	/// `begun` is the start of the run on the clock of the loops, and `ticks` the capacity of a recording. The arguments must outlive this
	/// object.
	SceneHooks(const Scene& scene, const SceneWorld& world, std::list<PlayedHand>& hands, SceneSwitches& switches, std::int64_t begun,
		size_t ticks);
	SceneHooks(const SceneHooks&) = delete;
	SceneHooks& operator=(const SceneHooks&) = delete;

	/// Ends the run after the tick in progress.
	void stop();
	bool stopWanted() const { return m_stop.load(std::memory_order_relaxed); }
	/// Call this after the run. It writes counts and faults into the outcome, and recordings into their files. Each file is either
	/// complete or missing; the missing ones are listed in the outcome.
	void finish(SceneOutcome& outcome);

private:
	struct Row
	{
		double time;
		ist::Pose hand, tool;  // X_WH, X_WT
		ist::Wrench wrench;
	};
	struct Recording
	{
		const SceneHook* hook;
		std::vector<Row> rows;
	};
	/// Contacts with a body, or with the parts of another tracked hand.
	struct Counter
	{
		const void* body;  // null: `parts`
		const devicebridge::BulletHand* parts;
		SceneContactCount sum;
	};
	/// A contact whose beginning or end is an event.
	struct Touch
	{
		bool now = false, was = false;
	};
	struct Switched
	{
		std::int64_t at;
		const SceneSwitch* what;
		bool on;
	};
	/// What happened to one hand.
	struct HandEvents
	{
		PlayedHand* hand;
		ist::Pose X_PM;  // pose of the tool's mesh frame
		std::vector<Counter> counters;
		std::list<Recording> recordings;
		std::list<Touch> touches;
		std::vector<Switched> switched;
		std::vector<devicebridge::Fault> faults;
		std::uint64_t moreFaults = 0;
	};
	static constexpr size_t kMostFaults = 64, kMostSwitched = 256;

	void tie(HandEvents& events, const SceneHook& hook, size_t ticks);
	void tieToTick(HandEvents& events, const SceneHook& hook);
	void tieRecording(HandEvents& events, const SceneHook& hook, size_t ticks);
	void addCounters(HandEvents& events, const std::list<PlayedHand>& hands) const;
	static void count(HandEvents& events, const devicebridge::ToolContact& contact);
	std::string textOf(const SceneHook& hook) const;
	void tieToButton(HandEvents& events, const SceneHook& hook);
	void tieSwitchToContact(HandEvents& events, const SceneHook& hook);
	/// Stops, or switches.
	void act(HandEvents& events, const SceneHook& hook, SceneSwitch* what) noexcept;
	bool concerns(const SceneHook& hook, const devicebridge::ToolContact& contact) const;

	const Scene& m_scene;
	const SceneWorld& m_world;
	SceneSwitches& m_switches;
	std::int64_t m_begun;
	std::list<HandEvents> m_hands;
	std::atomic<bool> m_stop{false};
};
}  // namespace scenes
