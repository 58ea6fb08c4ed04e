// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Loop/SteppingThread.h"
#include "demos/scenes/Scene/SceneRun.h"

namespace scenes
{
/// The hooks of a scene file, connected to a stepping thread. All memory is allocated before the first tick.
class SceneHooks
{
public:
	/// `X_BW` is the pose of the device's world, `begun` the start of the run on the clock of `thread`, and `ticks` the capacity of a
	/// recording.
	SceneHooks(const Scene& scene, const SceneWorld& world, const ist::Pose& X_BW, devicebridge::SteppingThread& thread, std::int64_t begun,
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
		std::string file;
		bool whole = false;  // true: also tool and wrench, which are not known yet when the hand has a new pose
		std::vector<Row> rows;
	};
	static constexpr size_t kMostFaults = 64;

	void tie(const SceneHook& hook, size_t ticks);
	void count(const devicebridge::ToolContact& contact);
	/// Returns false when the recording is full.
	bool record(Recording& into, const devicebridge::DeviceState& state);
	std::string textOf(const Recording& recording) const;
	const SceneWorld& m_world;
	ist::Pose m_X_BW, m_X_PM;  // pose of the device's world; pose of the tool's mesh frame
	devicebridge::SteppingThread& m_thread;
	std::int64_t m_begun;
	std::vector<SceneContactCount> m_counts;
	std::vector<std::unique_ptr<Recording>> m_recordings;
	std::vector<devicebridge::Fault> m_faults;
	std::uint64_t m_moreFaults = 0;
	std::atomic<bool> m_stop{false};
};
}  // namespace scenes
