// SPDX-License-Identifier: Zlib
#include "TestSupport/SceneFiles/SceneReader.h"

#include "BulletISTCollision/Core/Platform/Utf8Path.h"

#include <filesystem>
#include <system_error>

using namespace ist;

namespace scenes
{
namespace
{
/// True when two names mean one file, however they are spelled, also through links. The file need not exist.
bool isSameFile(const std::string& a, const std::string& b)
{
	if (a.empty() || b.empty()) return false;
	namespace fs = std::filesystem;
	std::error_code failed;
	const fs::path first = ist::systemPath(a), second = ist::systemPath(b);
	if (fs::equivalent(first, second, failed)) return true;
	const fs::path left = fs::weakly_canonical(fs::absolute(first, failed), failed),
				   right = fs::weakly_canonical(fs::absolute(second, failed), failed);
	return a == b || (!left.empty() && left == right);
}
}  // namespace

/// Refuses a recording that would overwrite an input file.
void SceneReader::checkRecording(JsonFields& f, const std::string& file)
{
	if (m_problem) return;
	if (isSameFile(file, m_scene.file)) f.refuse("file", "is the scene file itself");
	for (const SceneAsset& asset : m_scene.assets)
		if (isSameFile(file, asset.mesh) || isSameFile(file, asset.ist)) f.refuse("file", "is that of the asset " + asset.name);
	for (const SceneHook& other : m_scene.hooks)
		if (isSameFile(file, other.file)) f.refuse("file", "another hook records into it already");
}

namespace
{
using Event = SceneHook::Event;
using Action = SceneHook::Action;

bool fits(Event event, Action action)
{
	switch (action)
	{
	case Action::Record: return event == Event::Transform || event == Event::HapticTick;
	case Action::Count: return event == Event::Collision;
	case Action::Force:
	case Action::Damping:
	case Action::Scale: return event == Event::HapticTick;
	case Action::Log: return event == Event::Fault;
	case Action::Stop: return event == Event::Fault || event == Event::Collision || event == Event::Button;
	case Action::Switch: return event == Event::Collision || event == Event::Button;
	}
	return false;
}
}  // namespace

void SceneReader::readHook(JsonFields& f)
{
	SceneHook hook;
	f.need("on");
	f.need("do");
	hook.event = static_cast<Event>(f.choice("on", 0, {"transform", "collision", "haptic-tick", "fault", "button"}));
	hook.action = static_cast<Action>(f.choice("do", 1, {"record", "count", "force", "damping", "scale", "log", "stop", "switch"}));
	if (!fits(hook.event, hook.action)) f.refuse("do", f.text("do") + " cannot be done on " + f.text("on"));
	if (f.has("hand")) hook.hand = find(f, "hand", f.text("hand"), m_scene.hands, "hand");
	if (hook.event == Event::Button)
	{
		hook.button = static_cast<int>(f.whole("button", 1, 1, kMostButtons));
		hook.atEnd = f.choice("when", 0, {"pressed", "released"}) == 1;
	}
	if (hook.event == Event::Collision && f.has("body")) hook.body = find(f, "body", f.text("body"), m_scene.bodies, "body");
	if (hook.action == Action::Record)
	{
		f.need("file");
		hook.file = fileName(f.text("file"));
		hook.place = placeOf(f, "file");
		checkRecording(f, hook.file);
	}
	if (hook.action == Action::Force) hook.force = f.vector("force", {}, 100);
	if (hook.action == Action::Damping)
	{
		hook.damping = f.number("damping", 0, 0, 1000);
		hook.angularDamping = f.number("angularDamping", 0, 0, 1000);
	}
	if (hook.action == Action::Scale) hook.factor = f.number("factor", 1, 0, 100);
	if (hook.action == Action::Switch) readSwitch(f, hook);
	m_scene.hooks.push_back(hook);
}

void SceneReader::readSwitch(JsonFields& f, SceneHook& hook)
{
	if (hook.event == Event::Collision) hook.atEnd = f.choice("when", 0, {"begins", "ends"}) == 1;
	f.need("what");
	hook.what = static_cast<SceneHook::What>(f.choice("what", 0, {"friction", "coupling", "forces", "pair"}));
	hook.to = static_cast<SceneHook::To>(f.choice("to", 0, {"toggle", "on", "off"}));
	hook.startsOff = f.choice("start", 0, {"on", "off"}) == 1;
	if (hook.what == SceneHook::What::Pair) return readSwitchedPair(f, hook);
	for (size_t i = 0; i < m_scene.hands.size(); ++i)
	{
		const SceneHand& hand = m_scene.hands[i];
		if (hook.what != SceneHook::What::Coupling || (hook.hand && *hook.hand != i)) continue;
		if (hand.parts) f.refuse("what", hand.name + " has parts, and each part has a coupling of its own that cannot be switched");
		if (hand.coupling.isStatic)
			f.refuse("what", "the coupling of " + hand.name + " is static: its tool has no momentum to go on by itself");
	}
}

/// Reads the pair of a switch, which is one of those in `pairs`, in any order.
void SceneReader::readSwitchedPair(JsonFields& f, SceneHook& hook)
{
	f.need("pair");
	const JsonValue* names = f.list("pair");
	if (!names || m_problem) return;
	if (names->size() != 2 || !(*names)[0].isText() || !(*names)[1].isText()) return f.refuse("pair", "wants the names of two bodies");
	const std::string a = (*names)[0].text(), b = (*names)[1].text();
	const auto isThis = [&](const std::string& one, const std::string& other) {
		return (one == a && other == b) || (one == b && other == a);
	};
	for (size_t i = 0; i < m_scene.pairs.size(); ++i)
		if (isThis(m_scene.bodies[m_scene.pairs[i].first].name, m_scene.bodies[m_scene.pairs[i].second].name)) hook.pair = i;
	for (size_t i = 0; i < m_scene.partPairs.size(); ++i)
		if (isThis(m_scene.hands[m_scene.partPairs[i].first].name, m_scene.bodies[m_scene.partPairs[i].second].name)) hook.partPair = i;
	if (!hook.pair && !hook.partPair) f.refuse("pair", "wants one of the pairs that the field pairs of the scene lists");
}
}  // namespace scenes
