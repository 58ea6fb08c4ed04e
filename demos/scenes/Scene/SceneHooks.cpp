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
	const Scene& scene, const SceneWorld& world, std::list<PlayedHand>& hands, SceneSwitches& switches, std::int64_t begun, size_t ticks)
	: m_scene(scene),
	  m_world(world),
	  m_switches(switches),
	  m_begun(begun)
{
	size_t number = 0;
	for (PlayedHand& hand : hands)
	{
		HandEvents& events = m_hands.emplace_back();
		events.hand = &hand;
		if (!hand.parts) events.X_PM = inverse(world.body(hand.scene->tool).X_MP);
		events.faults.reserve(kMostFaults);
		events.switched.reserve(kMostSwitched);
		addCounters(events, hands);
		for (const SceneHook& hook : scene.hooks)
			if (!hook.hand || *hook.hand == number) tie(events, hook, ticks);
		++number;
	}
}

void SceneHooks::tie(HandEvents& events, const SceneHook& hook, size_t ticks)
{
	using Action = SceneHook::Action;
	using Event = SceneHook::Event;
	SteppingThread& thread = *events.hand->thread;
	if (hook.event == Event::Button) return tieToButton(events, hook);
	switch (hook.action)
	{
	case Action::Record: return tieRecording(events, hook, ticks);
	case Action::Count:
		thread.onCollision.addDelegate([this, &events, &hook](const ToolContact& contact) {
			if (concerns(hook, contact)) count(events, contact);
		});
		return;
	case Action::Switch: return tieSwitchToContact(events, hook);
	case Action::Force:
	case Action::Damping:
	case Action::Scale: return tieToTick(events, hook);
	case Action::Log:
		thread.onFault.addDelegate([&events](const Fault& fault) {
			if (events.faults.size() < kMostFaults) events.faults.push_back(fault);
			else ++events.moreFaults;
		});
		return;
	case Action::Stop:
		if (hook.event == Event::Fault) thread.onFault.addDelegate([this](const Fault&) { stop(); });
		else
			thread.onCollision.addDelegate([this, &hook](const ToolContact& contact) {
				if (concerns(hook, contact)) stop();
			});
		return;
	}
}

bool SceneHooks::concerns(const SceneHook& hook, const ToolContact& contact) const
{
	return !hook.body || m_world.body(*hook.body).body.get() == contact.other;
}

void SceneHooks::act(HandEvents& events, const SceneHook& hook, SceneSwitch* what) noexcept
{
	if (!what) return stop();
	const bool on = m_switches.change(*what, hook.to);
	if (events.switched.size() < kMostSwitched) events.switched.push_back({events.hand->thread->state().sampledAt, what, on});
}

/// A button that is held in the first sample has not been pressed.
void SceneHooks::tieToButton(HandEvents& events, const SceneHook& hook)
{
	SceneSwitch* const what = m_switches.find(hook, *events.hand);
	const std::uint32_t bit = 1u << (hook.button - 1);
	std::uint32_t before = ~0u;
	bool first = true;
	events.hand->thread->onTransform.addDelegate([=, this, &events, &hook](const DeviceState& state) mutable {
		const bool was = (before & bit) != 0, is = (state.buttons & bit) != 0;
		if (!first && was != is && is == !hook.atEnd) act(events, hook, what);
		before = state.buttons;
		first = false;
	});
}

void SceneHooks::tieSwitchToContact(HandEvents& events, const SceneHook& hook)
{
	SceneSwitch* const what = m_switches.find(hook, *events.hand);
	Touch& touch = events.touches.emplace_back();
	events.hand->thread->onCollision.addDelegate(
		[this, &hook, &touch](const ToolContact& contact) { touch.now = touch.now || concerns(hook, contact); });
	events.hand->thread->onHapticTick.addDelegate([this, &events, &hook, &touch, what](const DeviceState&, const Wrench&) {
		if (touch.now != touch.was && touch.now == !hook.atEnd) act(events, hook, what);
		touch.was = touch.now;
		touch.now = false;
	});
}

void SceneHooks::tieToTick(HandEvents& events, const SceneHook& hook)
{
	using Action = SceneHook::Action;
	SteppingThread& thread = *events.hand->thread;
	const SceneHook h = hook;
	if (h.action == Action::Force) thread.onHapticTick.addDelegate([h](const DeviceState&, Wrench& wrench) { wrench.force += h.force; });
	if (h.action == Action::Scale) thread.onHapticTick.addDelegate([h](const DeviceState&, Wrench& wrench) { wrench = h.factor * wrench; });
	if (h.action == Action::Damping)
		thread.onHapticTick.addDelegate([h](const DeviceState& state, Wrench& wrench) {
			wrench.force -= h.damping * state.twist.linear;
			wrench.torque -= h.angularDamping * state.twist.angular;
		});
}

void SceneHooks::tieRecording(HandEvents& events, const SceneHook& hook, size_t ticks)
{
	Recording& into = events.recordings.emplace_back();
	into.hook = &hook;
	into.rows.reserve(ticks);
	SteppingThread& thread = *events.hand->thread;
	const auto record = [&into, &thread](const DeviceState& state, const Wrench& wrench) {
		if (into.rows.size() == into.rows.capacity()) return;
		into.rows.push_back({1e-9 * static_cast<double>(state.sampledAt), state.X_WH, thread.step().tool.X_WT, wrench});
	};
	if (hook.event == SceneHook::Event::Transform)
		thread.onTransform.addDelegate([record](const DeviceState& state) { record(state, {}); });
	else thread.onHapticTick.addDelegate(record);
}

void SceneHooks::stop()
{
	m_stop.store(true, std::memory_order_relaxed);
	for (HandEvents& events : m_hands) events.hand->thread->requestStop();
}

void SceneHooks::addCounters(HandEvents& events, const std::list<PlayedHand>& hands) const
{
	const std::string& name = events.hand->scene->name;
	for (size_t i = 0; i < m_world.size(); ++i)
		events.counters.push_back({m_world.body(i).body.get(), nullptr, {name, m_world.body(i).name, 0, 0, 0}});
	for (const PlayedHand& other : hands)
		if (other.parts && &other != events.hand)
			events.counters.push_back({nullptr, other.parts.get(), {name, other.scene->name, 0, 0, 0}});
}

void SceneHooks::count(HandEvents& events, const ToolContact& contact)
{
	const auto* object = static_cast<const btCollisionObject*>(contact.other);
	for (Counter& c : events.counters)
	{
		if (c.parts ? c.parts->partOf(object) < 0 : c.body != object) continue;
		++c.sum.ticks;
		c.sum.maxVolume = std::max(c.sum.maxVolume, contact.volume);
		c.sum.maxForce = std::max(c.sum.maxForce, norm(contact.onTool.force));
	}
}

/// The rows of all hands, in the order of their times.
std::string SceneHooks::textOf(const SceneHook& hook) const
{
	const bool whole = hook.event == SceneHook::Event::HapticTick, named = m_scene.hands.size() > 1;
	std::vector<std::pair<const HandEvents*, const Row*>> rows;
	for (const HandEvents& events : m_hands)
		for (const Recording& recording : events.recordings)
			if (recording.hook == &hook)
				for (const Row& row : recording.rows) rows.push_back({&events, &row});
	std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.second->time < b.second->time; });
	std::string text = named ? "hand," : "";
	text += kHandHeader;
	text += whole ? kToolHeader : "";
	text += "\n";
	for (const auto& [events, row] : rows)
	{
		if (named) text += csvText(events->hand->scene->name) + ",";
		text += formatNumber(row->time - rows.front().second->time, 9) + csvPose(row->hand);
		const Wrench& w = row->wrench;
		if (whole)
			text += csvPose(events->hand->X_BW * row->tool * events->X_PM) +
				csvCells({w.force.x, w.force.y, w.force.z, w.torque.x, w.torque.y, w.torque.z});
		text += "\n";
	}
	return text;
}

void SceneHooks::finish(SceneOutcome& outcome)
{
	std::vector<std::pair<std::int64_t, std::string>> switched;
	const auto secondsAt = [this](std::int64_t at) {
		char text[40];
		std::snprintf(text, sizeof text, " at %.3f s", 1e-9 * static_cast<double>(at - m_begun));
		return std::string(text);
	};
	for (const HandEvents& events : m_hands)
	{
		const std::string hand = m_scene.hands.size() > 1 ? events.hand->scene->name + ": " : "";
		for (const Counter& c : events.counters)
			if (c.sum.ticks > 0) outcome.counts.push_back(c.sum);
		for (const Fault& fault : events.faults)
		{
			outcome.faults.push_back(hand + describe(fault.cause) + secondsAt(fault.at));
		}
		for (const Switched& s : events.switched)
			switched.push_back({s.at, hand + s.what->name + (s.on ? " on" : " off") + secondsAt(s.at)});
		if (events.moreFaults > 0) outcome.faults.push_back(hand + "and " + std::to_string(events.moreFaults) + " more");
	}
	std::stable_sort(switched.begin(), switched.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
	for (const auto& [at, text] : switched) outcome.switched.push_back(text);
	for (const SceneHook& hook : m_scene.hooks)
		if (hook.action == SceneHook::Action::Record && !writeTextFile(hook.file, textOf(hook))) outcome.unwritten.push_back(hook.file);
}
}  // namespace scenes
