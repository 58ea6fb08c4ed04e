// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Loop/SteppingThread.h"
#include "demos/scenes/Scene/SceneRun.h"

namespace scenes
{
/// The hooks of a scene file, tied to a stepping thread. All memory is there before the first tick.
class SceneHooks
{
public:
	/// `X_BW`: of the device's world; `begun`: when the session begins, by the clock of `thread`; `ticks`: how many a recording can hold.
	SceneHooks(const Scene& scene, const SceneWorld& world, const ist::Pose& X_BW, devicebridge::SteppingThread& thread, std::int64_t begun,
		size_t ticks);
	SceneHooks(const SceneHooks&) = delete;
	SceneHooks& operator=(const SceneHooks&) = delete;

	bool stopWanted() const { return m_stop.load(std::memory_order_relaxed); }
	/// After the run: counts and faults into the outcome, recordings into their files, each of which is whole or not there, and into the
	/// outcome which of them are not.
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
		bool whole = false;  // tool and wrench too; a new pose of the hand has neither yet
		std::vector<Row> rows;
	};
	static constexpr size_t kMostFaults = 64;

	void tie(const SceneHook& hook, size_t ticks);
	void count(const devicebridge::ToolContact& contact);
	/// False when there is no place for another row.
	bool record(Recording& into, const devicebridge::DeviceState& state);
	std::string textOf(const Recording& recording) const;
	void stop();

	const SceneWorld& m_world;
	ist::Pose m_X_BW, m_X_PM;  // of the device's world; of the tool's mesh frame
	devicebridge::SteppingThread& m_thread;
	std::int64_t m_begun;
	std::vector<SceneContactCount> m_counts;
	std::vector<std::unique_ptr<Recording>> m_recordings;
	std::vector<devicebridge::Fault> m_faults;
	std::uint64_t m_moreFaults = 0;
	std::atomic<bool> m_stop{false};
};
}  // namespace scenes
