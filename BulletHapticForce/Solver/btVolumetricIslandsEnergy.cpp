// SPDX-License-Identifier: Zlib
// The energy tanks of an island's contacts.
#include "BulletHapticForce/Solver/btVolumetricIslands.h"

#include "BulletHapticForce/Solver/btSolverBodyMotion.h"

#include <algorithm>
#include <iterator>

using namespace btSolverBodyMotion;

namespace
{
constexpr double kWorthSoftening = 0.99;  // share of a contact's impulses from which on it is not softened
}  // namespace

void btVolumetricIslands::openEnergyTanks(const btSolverBody* bodies)
{
	const btISTContact* former = nullptr;
	for (const Entry& e : m_entries)
	{
		if (e.contact == former) continue;
		former = e.contact;
		const auto velocityAt = [&](int body, const ist::Vec3& point) {
			// The velocities that moved the bodies to these poses, without the impulses of this step.
			const btSolverBody& b = bodies[body];
			return toVec3(b.m_linearVelocity) + cross(toVec3(b.m_angularVelocity), point - toVec3(b.getWorldTransform().getOrigin()));
		};
		const ist::Vec3 centroid = e.contact->total.firstMoment / e.contact->total.volume;
		const ist::Vec3 point = e.contact->X_WA * (e.contact->treeA->origin + centroid);
		const double speed = norm(velocityAt(e.bodyA, point) - velocityAt(e.bodyB, point));
		m_statistics.contactsTurnedOver += btContactEnergyTank::begin(*e.contact, speed, m_step);
	}
}

/// Adds the effect of an impulse of `e` to the changes of the bodies' twists.
void btVolumetricIslands::addChange(const Entry& e, const ist::Wrench& impulse, const btSolverBody* bodies)
{
	for (int side = 0; side < 2; ++side)
	{
		const int body = side == 0 ? e.bodyA : e.bodyB;
		if (!canMove(bodies[body])) continue;
		const ist::Twist change = response(rowBody(bodies[body]), (side == 0 ? 1.0 : -1.0) * impulse, e.patch.point);
		m_change[size_t(body)] = m_change[size_t(body)] + change;
	}
}

std::vector<ist::Twist>& btVolumetricIslands::sumChanges(const btSolverBody* bodies)
{
	std::fill(m_change.begin(), m_change.end(), ist::Twist());
	for (const Entry& e : m_entries) addChange(e, e.impulse, bodies);
	return m_change;
}

/// Collects the patches of a contact, which are `count` entries from `first` on. Their `own` is what this contact has changed, or, if
/// asked for, all contacts together. `before` is the motion without any contact, or, if asked for, with all others.
void btVolumetricIslands::gatherEnergyTank(size_t first, int count, const btSolverBody* bodies, Own whose, btEnergyTankPatch* patches) const
{
	const Entry& e = m_entries[first];
	const auto relativeAt = [&](const ist::Twist& a, const ist::Twist& b, const ist::Vec3& point) {
		return movedTo(a, bodies[e.bodyA], point) - movedTo(b, bodies[e.bodyB], point);
	};
	const ist::Twist all[2] = {m_change[size_t(e.bodyA)], m_change[size_t(e.bodyB)]};
	const ist::Twist after[2] = {twist(bodies[e.bodyA]), twist(bodies[e.bodyB])};
	ist::Twist before[2] = {after[0] - all[0], after[1] - all[1]};
	ist::Twist own[2] = {all[0], all[1]};
	if (whose != Own::All)
		for (int side = 0; side < 2; ++side)
		{
			own[side] = {};
			const btSolverBody& body = bodies[side == 0 ? e.bodyA : e.bodyB];
			if (!canMove(body)) continue;
			for (size_t i = first; i < first + size_t(count); ++i)
				own[side] = own[side] + response(rowBody(body), (side == 0 ? 1.0 : -1.0) * m_entries[i].impulse, m_entries[i].patch.point);
		}
	if (whose == Own::ContactAfterOthers)
		for (int side = 0; side < 2; ++side) before[side] = after[side] - own[side];
	for (int i = 0; i < count; ++i)
	{
		const Entry& entry = m_entries[first + size_t(i)];
		const ist::Vec3& point = entry.patch.point;
		patches[i] = {entry.patch, entry.impulse, entry.elastic, relativeAt(before[0], before[1], point),
			relativeAt(after[0], after[1], point), relativeAt(own[0], own[1], point)};
	}
}

/// Scales the impulse of a patch by `share`.
void btVolumetricIslands::scale(Entry& e, double share, btSolverBody* bodies)
{
	const ist::Wrench change = (share - 1) * e.impulse;
	applyImpulse(bodies[e.bodyA], change, e.patch.point);
	applyImpulse(bodies[e.bodyB], -1.0 * change, e.patch.point);
	addChange(e, change, bodies);
	e.impulse = share * e.impulse;
	e.elastic = share * e.elastic;
	e.normalImpulse *= share;
}

/// Largest share of a contact's impulses that returns no more than its tank holds.
double btVolumetricIslands::shareOf(size_t first, int count, const btSolverBody* bodies, Own whose) const
{
	btEnergyTankPatch patches[btISTContact::kMaxPatches];
	gatherEnergyTank(first, count, bodies, whose, patches);
	return btContactEnergyTank::share(btContactEnergyTank::scaledWork(patches, count), m_entries[first].contact->tank.stored);
}

/// Limits every contact of the island to its tank while the others stay as they are. Others may press bodies together that part by
/// themselves: their contact takes up what these give, and is judged by the motion that they leave. All this changes the work of the
/// others, so all together are then limited to the sum of their tanks.
void btVolumetricIslands::holdToEnergyTanks(const Island& island, btSolverBody* bodies)
{
	btEnergyTankPatch patches[btISTContact::kMaxPatches];
	const auto hold = [&](size_t first, int count, double share) {
		for (int i = 0; i < count; ++i) scale(m_entries[first + size_t(i)], share, bodies);
	};
	double stored = 0;
	bool held = false;
	forEachContact(island, [&](size_t first, int count) {
		stored += m_entries[first].contact->tank.stored;
		const double alone = shareOf(first, count, bodies, Own::Contact);
		if (!(alone < 1)) return;
		held = true;
		const double share = std::max(alone, shareOf(first, count, bodies, Own::ContactAfterOthers));
		if (!(share < 1)) return;
		++m_statistics.contactsHeldToEnergyTank;
		hold(first, count, share);
	});
	if (!held) return;
	btScaledWork all;
	forEachContact(island, [&](size_t first, int count) {
		gatherEnergyTank(first, count, bodies, Own::All, patches);
		const btScaledWork work = btContactEnergyTank::scaledWork(patches, count);
		all = {all.linear + work.linear, all.square + work.square};
	});
	const double share = btContactEnergyTank::share(all, stored);
	if (share < 1) forEachContact(island, [&](size_t first, int count) { hold(first, count, share); });
}

void btVolumetricIslands::holdToEnergyTanks(btSolverBody* bodies)
{
	if (m_heldToEnergyTanks) return;
	m_heldToEnergyTanks = true;
	for (const Island& island : m_islands) holdToEnergyTanks(island, bodies);
}

/// Enters the work of the island's contacts into their tanks. What one has returned beyond its own, the others pay.
void btVolumetricIslands::enterWork(const Island& island, const btSolverBody* bodies)
{
	btEnergyTankPatch patches[btISTContact::kMaxPatches];
	double owed = 0, left = 0;
	forEachContact(island, [&](size_t first, int count) {
		gatherEnergyTank(first, count, bodies, Own::Contact, patches);
		btISTContact& contact = *m_entries[first].contact;
		const double stored = contact.tank.stored;
		owed += std::max(btContactEnergyTank::enter(contact.tank, patches, count, m_step) - stored, 0.0);
		left += contact.tank.stored + contact.tank.damped;
		contact.work = btContactEnergyTank::workOf(patches, count);
	});
	if (!(owed > 0)) return;
	const double kept = left > owed ? 1 - owed / left : 0;
	forEachContact(island, [&](size_t first, int) {
		btISTContactEnergyTank& tank = m_entries[first].contact->tank;
		tank.stored *= kept;
		tank.damped *= kept;
	});
}

/// Softens every contact that would return more energy than its tank holds, so that the others of the island can bear what it does not.
/// Returns true if there was one.
bool btVolumetricIslands::softenToEnergyTanks(const Island& island, const btSolverBody* bodies)
{
	for (const int body : m_passing.bodies) m_change[size_t(body)] = ist::Twist();
	for (const int i : m_passing.entries) addChange(m_entries[size_t(i)], m_entries[size_t(i)].impulse, bodies);
	bool softened = false;
	forEachContact(island, [&](size_t first, int count) {
		const double alone = shareOf(first, count, bodies, Own::Contact);
		if (!(alone < kWorthSoftening)) return;
		const double share = std::max(alone, shareOf(first, count, bodies, Own::ContactAfterOthers));
		if (!(share < kWorthSoftening)) return;
		for (size_t i = first; i < first + size_t(count); ++i) multiply(m_entries[i].patch, share);
		softened = true;
	});
	return softened;
}
