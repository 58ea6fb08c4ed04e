// SPDX-License-Identifier: Zlib
#include "demos/scenes/Study/TrialWatch.h"

#include <string>

using namespace devicebridge;

namespace scenes
{
bool TrialWatch::happens(const StudyEvent& event, Seen& seen, SteppingThread& thread, const SceneWorld& world)
{
	if (event.kind == StudyEvent::Kind::Button)
	{
		const bool pressed = (thread.state().buttons >> (event.button - 1) & 1U) != 0, now = pressed && !seen.pressed;
		seen.pressed = pressed;
		return now;
	}
	std::uint64_t touched = 0;
	const ToolStep& step = thread.step();
	for (int i = 0; i < step.contactCount; ++i)
	{
		const char* name = world.nameOf(step.contacts[i].other);
		if (event.bodies.empty()) touched = 1, m_touched = seen.touched ? m_touched : name;
		for (size_t k = 0; k < event.bodies.size(); ++k)
		{
			if (event.bodies[k] != name) continue;
			touched |= std::uint64_t(1) << k;
			if (!(seen.touched >> k & 1U)) m_touched = name;
		}
	}
	const bool now = (touched & ~seen.touched) != 0;
	seen.touched = touched;
	return now;
}

bool TrialWatch::look(SteppingThread& thread, const SceneWorld& world)
{
	using Kind = StudyEvent::Kind;
	const std::int64_t at = thread.state().sampledAt;
	if (++m_tick == 0) m_start = at;
	// The run ends a tick later: the last tick of a run sends zero.
	if (ended()) return false;
	const auto reached = [&](std::int64_t since, double limit) { return static_cast<double>(at - since) >= 1e9 * limit; };
	if (!begun())
	{
		const bool awaited = m_study.begin.kind != Kind::None;
		if (m_study.begin.kind == Kind::Button) thread.enableForces(false);
		if (awaited && !happens(m_study.begin, m_seenBegin, thread, world)) return m_late = reached(m_start, m_study.waitLimit), !m_late;
		m_begin = m_tick;
		m_begunAt = at;
		// Where the trial begins in another way, a hook of the scene may have switched the forces off.
		if (m_study.begin.kind == Kind::Button) thread.enableForces(true);
	}
	const bool ends = m_study.end.kind != Kind::None && happens(m_study.end, m_seenEnd, thread, world) && m_tick > m_begin;
	m_late = !ends && reached(m_begunAt, m_study.timeLimit);
	if (ends || m_late) m_end = m_tick;
	return true;
}

std::string TrialWatch::endedBy() const
{
	if (!begun()) return m_late ? "no begin" : "";
	if (!ended()) return "";
	if (m_late) return "time limit";
	return m_study.end.kind == StudyEvent::Kind::Button ? "button " + std::to_string(m_study.end.button) : m_touched;
}
}  // namespace scenes
