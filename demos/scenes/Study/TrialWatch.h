// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Scene/SceneRun.h"
#include "demos/scenes/Study/StudyFile.h"

namespace scenes
{
/// Watches the ticks of a run for the begin and the end of a trial. While a button is awaited to begin, the device of the first hand gets
/// no force; those of others do.
class TrialWatch
{
public:
	explicit TrialWatch(const Study& study) : m_study(study) {}

	/// Looks at a tick. Returns false in the tick after the end of the trial. Allocates nothing.
	bool look(devicebridge::SteppingThread& thread, const SceneWorld& world);

	bool begun() const { return m_begin >= 0; }
	bool ended() const { return m_end >= 0; }
	/// Numbers of the ticks in which the trial began and ended; negative: it did not.
	std::int64_t beginTick() const { return m_begin; }
	std::int64_t endTick() const { return m_end; }
	/// What ended the trial: "button 1", the name of a body, "time limit", "no begin", or empty where the run ended before.
	std::string endedBy() const;

private:
	struct Seen
	{
		bool pressed = true;  // in the tick before; a button that is held from the start does not count
		std::uint64_t touched = ~std::uint64_t(0);
	};
	bool happens(const StudyEvent& event, Seen& seen, devicebridge::SteppingThread& thread, const SceneWorld& world);

	const Study& m_study;
	Seen m_seenBegin, m_seenEnd;
	const char* m_touched = nullptr;  // name of the body whose contact was the last event
	std::int64_t m_tick = -1, m_begin = -1, m_end = -1, m_start = 0, m_begunAt = 0;
	bool m_late = false;
};
}  // namespace scenes
