// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletHeatMap.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

#include <limits>

using namespace ist;

namespace devicebridge
{
std::unique_ptr<HeatMap> makeHeatMap(const HandModel& hand, Mesh object)
{
	auto map = std::make_unique<HeatMap>(std::move(object));
	for (int i = 0; i < kHandParts; ++i)
		map->addPart(handPartName(i, hand.shape.left), handPartId(i, hand.shape.left), hand.parts[static_cast<std::size_t>(i)].mesh);
	return map;
}

namespace
{
/// Calls `use` with each part that touches and its contact, which represents `seconds`.
template <class Use>
void forEachTouch(const BulletHand& hand, const btISTContactStore& contacts, const btRigidBody& object, const Pose& X_BM, double h,
	double seconds, const Use& use)
{
	const Pose X_MW = inverse(toPose(object.getWorldTransform()) * X_BM);
	for (const btISTContact* contact : contacts.contacts())
	{
		if (!touchedInLastStep(contacts, *contact)) continue;
		if (contact->bodyA != &object && contact->bodyB != &object) continue;
		const int part = hand.partOf(contact->bodyA == &object ? contact->bodyB : contact->bodyA);
		if (part < 0) continue;
		Vec3 pressed;
		for (int i = 0; i < contact->patchCount; ++i)
		{
			const Vec3 normal = contact->X_WA.rotation * normalized(contact->patches[i].areaVector);
			pressed += dot(contact->impulses[i].force, normal) / h * normal;
		}
		const Vec3 point = contact->X_WA * (contact->treeA->origin + contact->total.firstMoment / contact->total.volume);
		use(part, HeatMapContact{X_MW * toPose(hand.body(part).getWorldTransform()), norm(pressed), X_MW * point, seconds});
	}
}
}  // namespace

double addTouches(HeatMap& map, const BulletHand& hand, const btISTContactStore& contacts, const btRigidBody& object, const Pose& X_BM,
	double h, double seconds) noexcept
{
	double sum = 0;
	forEachTouch(hand, contacts, object, X_BM, h, seconds, [&](int part, const HeatMapContact& contact) {
		map.add(part, contact);
		sum += contact.force;
	});
	return sum;
}

BulletHeatMapRounds::BulletHeatMapRounds(HeatMap& map, int budget) : m_map(map), m_budget(budget) { m_touches.reserve(4 * kHandParts); }

/// Returns true if the present moment is done.
bool BulletHeatMapRounds::work(int budget)
{
	for (; !m_touches.empty() && budget > 0; m_touches.pop_back())
	{
		const Touch& touch = m_touches.back();
		if (!m_begun) m_map.begin(touch.part, touch.contact);
		m_begun = !m_map.advance(budget);
		if (m_begun) return false;
	}
	return m_touches.empty();
}

void BulletHeatMapRounds::step(
	const BulletHand& hand, const btISTContactStore& contacts, const btRigidBody& object, const Pose& X_BM, double h)
{
	m_since += h;
	if (!work(m_budget)) return;
	forEachTouch(hand, contacts, object, X_BM, h, m_since, [&](int part, const HeatMapContact& contact) {
		m_touches.push_back({part, contact});
		m_impulse += contact.force * contact.seconds;
	});
	++m_rounds;
	m_seconds += m_since;
	m_since = 0;
}

void BulletHeatMapRounds::finish() { work(std::numeric_limits<int>::max()); }
}  // namespace devicebridge
