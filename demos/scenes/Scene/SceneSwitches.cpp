// SPDX-License-Identifier: Zlib
#include "demos/scenes/Scene/SceneSwitches.h"

#include "DeviceBridge/Bullet/BulletContactSource.h"

#include <iterator>

namespace scenes
{
using What = SceneHook::What;
using devicebridge::kHandParts;

namespace
{
const char* wordFor(What what)
{
	switch (what)
	{
	case What::Friction: return "friction";
	case What::Coupling: return "coupling";
	case What::Forces: return "forces";
	case What::Pair: return "pair";
	}
	return "";
}
}  // namespace

SceneSwitches::SceneSwitches(const Scene& scene, SceneWorld& world, std::list<PlayedHand>& hands) : m_scene(scene), m_world(world)
{
	for (const SceneHook& hook : scene.hooks)
	{
		if (hook.action != SceneHook::Action::Switch) continue;
		size_t number = 0;
		for (PlayedHand& hand : hands)
		{
			if (!hook.hand || *hook.hand == number) add(hook, hand, hands);
			++number;
		}
	}
	// The world forgets what starts off, and keeps the memory for it.
	applyToWorld();
}

SceneSwitch* SceneSwitches::find(const SceneHook& hook, const PlayedHand& hand)
{
	if (hook.action != SceneHook::Action::Switch) return nullptr;
	for (SceneSwitch& s : m_switches)
		if (s.what == hook.what && s.pair == hook.pair && s.partPair == hook.partPair && (hook.what == What::Pair || s.hand == &hand))
			return &s;
	return nullptr;
}

void SceneSwitches::add(const SceneHook& hook, PlayedHand& hand, const std::list<PlayedHand>& hands)
{
	SceneSwitch* s = find(hook, hand);
	if (!s)
	{
		s = &m_switches.emplace_back();
		s->what = hook.what;
		s->pair = hook.pair;
		s->partPair = hook.partPair;
		s->name = wordFor(hook.what);
		if (hook.what == What::Pair) addPairs(hook, hands, *s);
		else s->hand = &hand;
		const auto addBody = [&](btRigidBody& body) {
			s->rubbing.push_back({&body, body.getFriction(), body.getRollingFriction(), body.getSpinningFriction()});
		};
		if (hook.what == What::Friction && !hand.parts) addBody(*m_world.body(hand.scene->tool).body);
		for (int part = 0; hook.what == What::Friction && hand.parts && part < kHandParts; ++part) addBody(hand.parts->body(part));
	}
	if (hook.startsOff) change(*s, SceneHook::To::Off);
}

void SceneSwitches::addPairs(const SceneHook& hook, const std::list<PlayedHand>& hands, SceneSwitch& out) const
{
	const auto& [a, b] = hook.pair ? m_scene.pairs[*hook.pair] : m_scene.partPairs[*hook.partPair];
	const btCollisionObject* const second = m_world.body(b).body.get();
	out.name += " " + (hook.pair ? m_scene.bodies[a].name : m_scene.hands[a].name) + ", " + m_scene.bodies[b].name;
	if (hook.pair) return out.pairs.push_back({m_world.body(a).body.get(), second});
	const PlayedHand& hand = *std::next(hands.begin(), static_cast<std::ptrdiff_t>(a));
	for (int part = 0; part < kHandParts; ++part) out.pairs.push_back({&hand.parts->body(part), second});
}

bool SceneSwitches::change(SceneSwitch& s, SceneHook::To to) noexcept
{
	if (to == SceneHook::To::Toggle) s.on.fetch_xor(1, std::memory_order_relaxed);
	else s.on.store(to == SceneHook::To::On ? 1 : 0, std::memory_order_relaxed);
	const bool on = s.on.load(std::memory_order_relaxed) != 0;
	if (s.what == What::Forces) s.hand->thread->enableForces(on);
	if (s.what == What::Coupling && s.hand->inLoop) s.hand->inLoop->setCoupled(on);
	if (s.what == What::Coupling && s.hand->decoupled) s.hand->decoupled->setCoupled(on);
	if (m_scene.topology == SceneTopology::OneThread) applyToWorld(s);
	return on;
}

void SceneSwitches::applyToWorld() noexcept
{
	for (SceneSwitch& s : m_switches) applyToWorld(s);
}

void SceneSwitches::applyToWorld(SceneSwitch& s) noexcept
{
	const unsigned on = s.on.load(std::memory_order_relaxed);
	if (on == s.applied) return;
	s.applied = on;
	for (const auto& [body, sliding, rolling, spinning] : s.rubbing)
	{
		body->setFriction(on ? sliding : btScalar(0));
		body->setRollingFriction(on ? rolling : btScalar(0));
		body->setSpinningFriction(on ? spinning : btScalar(0));
	}
	btISTPairFilter& filter = m_world.world().pairFilter();
	for (const auto& [a, b] : s.pairs)
		if (on) filter.addPair(a, b);
		else filter.removePair(a, b);
}
}  // namespace scenes
