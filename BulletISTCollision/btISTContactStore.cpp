// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/btISTContactStore.h"

#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "BulletDynamics/Featherstone/btMultiBody.h"
#include "BulletDynamics/Featherstone/btMultiBodyLinkCollider.h"

#include <algorithm>
#include <cmath>

namespace
{
constexpr double kSinkagePerSize = 1e-3;
constexpr double kWaterDensity = 1000;  // [kg/m^3]

/// Of all links that can move: any one of them may carry the others.
double massOf(const btMultiBody& multiBody)
{
	double mass = multiBody.isBaseStaticOrKinematic() ? 0 : double(multiBody.getBaseMass());
	for (int i = 0; i < multiBody.getNumLinks(); ++i) mass += double(multiBody.getLinkMass(i));
	return mass;
}

/// Zero for whatever the solver cannot move.
double dynamicMass(const btCollisionObject* object)
{
	if (const auto* link = object ? btMultiBodyLinkCollider::upcast(object) : nullptr)
		return link->isStaticOrKinematicObject() ? 0 : massOf(*link->m_multiBody);
	const btRigidBody* body = object ? btRigidBody::upcast(object) : nullptr;
	if (!body || body->isStaticOrKinematicObject() || !(body->getInvMass() > 0)) return 0;
	return 1.0 / double(body->getInvMass());
}
}  // namespace

btISTPairConstants btISTDefaultPairRule::decide(const btISTContact& contact, const btCollisionObject* bodyA,
													 const btCollisionObject* bodyB) const
{
	double volume = contact.treeA->volume, gap = contact.treeA->meanGap;
	volume = std::min(volume, contact.treeB ? contact.treeB->volume : contact.volumeB);
	if (contact.treeB) gap += contact.treeB->meanGap;
	const double size = std::cbrt(volume);
	const double sinkage = std::max(kSinkagePerSize * size, gap);
	double mass = std::max(dynamicMass(bodyA), dynamicMass(bodyB));
	if (!(mass > 0)) mass = kWaterDensity * volume;

	btISTPairConstants constants;
	constants.loadMass = mass;
	constants.k = mass * m_gravity / (sinkage * size * size);
	if (contact.halfSpace)
	{
		constants.weightA = 0;
		constants.weightB = 1;
	}
	return constants;
}

void btISTContactStore::count(btISTContact& contact, const ist::OverlapResult* result, double seconds)
{
	addQueryTime(seconds);
	for (btISTQueryCost* cost : {&contact.cost, &m_cost})
	{
		cost->seconds += seconds;
		cost->asked += contact.use == btISTKeptResult::Ask;
		cost->keptApart += contact.use == btISTKeptResult::Apart;
		cost->keptStill += contact.use == btISTKeptResult::Still;
		cost->keptMoved += contact.use == btISTKeptResult::Moved;
		if (!result) continue;
		cost->querySeconds += seconds;
		cost->largestKeptError = std::max(cost->largestKeptError, contact.kept.foundError());
		cost->nodeVisits += result->nodeVisits;
		cost->ballTests += result->ballTests;
		cost->leafPairs += result->total.pairs;
	}
}

btISTContactStore::btISTContactStore() = default;
btISTContactStore::~btISTContactStore() = default;

btISTContact* btISTContactStore::find(const btPersistentManifold* manifold)
{
	const auto found = m_index.find(manifold);
	return found == m_index.end() ? nullptr : m_active[found->second];
}

const btISTContact* btISTContactStore::find(const btPersistentManifold* manifold) const
{
	return const_cast<btISTContactStore*>(this)->find(manifold);
}

btISTContact* btISTContactStore::acquire(const btPersistentManifold* manifold)
{
	if (m_free.empty())
	{
		m_pool.push_back(std::make_unique<btISTContact>());
		m_free.push_back(m_pool.back().get());
	}
	btISTContact* contact = m_free.back();
	m_free.pop_back();
	*contact = btISTContact();
	contact->manifold = manifold;
	m_index[manifold] = m_active.size();
	m_active.push_back(contact);
	return contact;
}

void btISTContactStore::release(const btPersistentManifold* manifold)
{
	const auto found = m_index.find(manifold);
	if (found == m_index.end()) return;
	const size_t at = found->second;
	btISTContact* contact = m_active[at];
	m_index.erase(found);
	if (m_active.back() != contact)
	{
		m_active[at] = m_active.back();
		m_index[m_active[at]->manifold] = at;
	}
	m_active.pop_back();
	// Trees are large; a pooled entry must not keep them alive.
	contact->treeA.reset();
	contact->memory.reset();
	contact->treeB.reset();
	contact->manifold = nullptr;
	m_free.push_back(contact);
}
