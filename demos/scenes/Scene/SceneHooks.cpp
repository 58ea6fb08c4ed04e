// SPDX-License-Identifier: Zlib
#include "demos/scenes/Scene/SceneHooks.h"

#include "demos/scenes/Pages/CsvCells.h"
#include "demos/scenes/Pages/HtmlReport.h"
#include "demos/scenes/Pages/TextFile.h"

#include <algorithm>
#include <cstdio>

using namespace ist;
using namespace devicebridge;

namespace scenes
{
namespace
{
constexpr const char* kHandHeader = "time,hand_x,hand_y,hand_z,hand_qx,hand_qy,hand_qz,hand_qw";
constexpr const char* kToolHeader =
	",tool_x,tool_y,tool_z,tool_qx,tool_qy,tool_qz,tool_qw,force_x,force_y,force_z,torque_x,torque_y,torque_z";
}  // namespace

SceneHooks::SceneHooks(
	const Scene& scene, const SceneWorld& world, const Pose& X_BW, SteppingThread& thread, std::int64_t begun, size_t ticks)
	: m_world(world),
	  m_X_BW(X_BW),
	  m_X_PM(inverse(world.body(scene.tool).X_MP)),
	  m_thread(thread),
	  m_begun(begun)
{
	m_faults.reserve(kMostFaults);
	for (const SceneBody& body : scene.bodies) m_counts.push_back({body.name, 0, 0, 0});
	for (const SceneHook& hook : scene.hooks) tie(hook, ticks);
}

void SceneHooks::tie(const SceneHook& hook, size_t ticks)
{
	using Action = SceneHook::Action;
	const SceneHook h = hook;
	if (h.action == Action::Count) m_thread.onCollision.addDelegate([this](const ToolContact& contact) { count(contact); });
	if (h.action == Action::Force) m_thread.onHapticTick.addDelegate([h](const DeviceState&, Wrench& wrench) { wrench.force += h.force; });
	if (h.action == Action::Scale)
		m_thread.onHapticTick.addDelegate([h](const DeviceState&, Wrench& wrench) { wrench = h.factor * wrench; });
	if (h.action == Action::Damping)
		m_thread.onHapticTick.addDelegate([h](const DeviceState& state, Wrench& wrench) {
			wrench.force -= h.damping * state.twist.linear;
			wrench.torque -= h.angularDamping * state.twist.angular;
		});
	if (h.action == Action::Log)
		m_thread.onFault.addDelegate([this](const Fault& fault) {
			if (m_faults.size() < kMostFaults) m_faults.push_back(fault);
			else ++m_moreFaults;
		});
	if (h.action == Action::Stop && h.event == SceneHook::Event::Fault) m_thread.onFault.addDelegate([this](const Fault&) { stop(); });
	if (h.action == Action::Stop && h.event == SceneHook::Event::Collision)
		m_thread.onCollision.addDelegate([this](const ToolContact&) { stop(); });
	if (h.action != Action::Record) return;
	m_recordings.push_back(std::make_unique<Recording>());
	Recording& into = *m_recordings.back();
	into.file = h.file;
	into.whole = h.event == SceneHook::Event::HapticTick;
	into.rows.reserve(ticks);
	if (!into.whole) m_thread.onTransform.addDelegate([this, &into](const DeviceState& state) { record(into, state); });
	else
		m_thread.onHapticTick.addDelegate([this, &into](const DeviceState& state, const Wrench& wrench) {
			if (record(into, state)) into.rows.back().wrench = wrench;
		});
}

void SceneHooks::stop()
{
	m_stop.store(true, std::memory_order_relaxed);
	m_thread.requestStop();
}

void SceneHooks::count(const ToolContact& contact)
{
	const char* name = m_world.nameOf(contact.other);
	for (SceneContactCount& c : m_counts)
	{
		if (c.body != name) continue;
		++c.ticks;
		c.maxVolume = std::max(c.maxVolume, contact.volume);
		c.maxForce = std::max(c.maxForce, norm(contact.onTool.force));
	}
}

bool SceneHooks::record(Recording& into, const DeviceState& state)
{
	if (into.rows.size() == into.rows.capacity()) return false;
	into.rows.push_back({1e-9 * static_cast<double>(state.sampledAt), state.X_WH, m_thread.step().tool.X_WT, {}});
	return true;
}

std::string SceneHooks::textOf(const Recording& recording) const
{
	std::string text = kHandHeader;
	text += recording.whole ? kToolHeader : "";
	text += "\n";
	for (const Row& row : recording.rows)
	{
		text += formatNumber(row.time - recording.rows.front().time, 9) + csvPose(row.hand);
		const Wrench& w = row.wrench;
		if (recording.whole)
			text += csvPose(m_X_BW * row.tool * m_X_PM) + csvCells({w.force.x, w.force.y, w.force.z, w.torque.x, w.torque.y, w.torque.z});
		text += "\n";
	}
	return text;
}

void SceneHooks::finish(SceneOutcome& outcome)
{
	for (const SceneContactCount& c : m_counts)
		if (c.ticks > 0) outcome.counts.push_back(c);
	for (const Fault& fault : m_faults)
	{
		char at[40];
		std::snprintf(at, sizeof at, " at %.3f s", 1e-9 * static_cast<double>(fault.at - m_begun));
		outcome.faults.push_back(describe(fault.cause) + std::string(at));
	}
	if (m_moreFaults > 0) outcome.faults.push_back("and " + std::to_string(m_moreFaults) + " more");
	for (const auto& recording : m_recordings)
		if (!writeTextFile(recording->file, textOf(*recording))) outcome.unwritten.push_back(recording->file);
}
}  // namespace scenes
