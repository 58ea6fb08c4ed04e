// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Registry/btISTPairFilter.h"

#include "BulletCollision/CollisionDispatch/btCollisionObject.h"
#include "BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h"
#include "BulletCollision/CollisionShapes/btCollisionShape.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace
{
constexpr btScalar kHysteresis = btScalar(0.05);  // share of the longest side
}

btISTPairFilter::Pair btISTPairFilter::sorted(const btCollisionObject* a, const btCollisionObject* b)
{
	return std::less<const btCollisionObject*>()(b, a) ? Pair(b, a) : Pair(a, b);
}

void btISTPairFilter::addPair(const btCollisionObject* a, const btCollisionObject* b)
{
	m_onlyPairs = true;
	const Pair pair = sorted(a, b);
	const auto at = std::lower_bound(m_pairs.begin(), m_pairs.end(), pair);
	if (at == m_pairs.end() || *at != pair) m_pairs.insert(at, pair);
}

void btISTPairFilter::removePair(const btCollisionObject* a, const btCollisionObject* b)
{
	const Pair pair = sorted(a, b);
	const auto at = std::lower_bound(m_pairs.begin(), m_pairs.end(), pair);
	if (at != m_pairs.end() && *at == pair) m_pairs.erase(at);
}

void btISTPairFilter::acceptAllPairs()
{
	m_onlyPairs = false;
	m_pairs.clear();
}

std::optional<ist::Error> btISTPairFilter::setRegion(const btVector3& lower, const btVector3& upper)
{
	for (int i = 0; i < 3; ++i)
		if (!std::isfinite(lower[i]) || !std::isfinite(upper[i]) || lower[i] > upper[i])
			return ist::Error{"a region needs two finite corners, the lower one first"};
	m_lower = lower;
	m_upper = upper;
	m_hasRegion = true;
	return std::nullopt;
}

bool btISTPairFilter::acceptsPair(const btCollisionObject* a, const btCollisionObject* b) const
{
	return !m_onlyPairs || std::binary_search(m_pairs.begin(), m_pairs.end(), sorted(a, b));
}

bool btISTPairFilter::accepts(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b, bool was) const
{
	if (!acceptsPair(a.getCollisionObject(), b.getCollisionObject())) return false;
	if (!m_hasRegion) return true;
	btVector3 lowerA, upperA, lowerB, upperB;
	a.getCollisionShape()->getAabb(a.getWorldTransform(), lowerA, upperA);
	b.getCollisionShape()->getAabb(b.getWorldTransform(), lowerB, upperB);
	return acceptsBoxes(lowerA, upperA, lowerB, upperB, was);
}

bool btISTPairFilter::acceptsBoxes(
	const btVector3& lowerA, const btVector3& upperA, const btVector3& lowerB, const btVector3& upperB, bool was) const
{
	if (!m_hasRegion) return true;
	const btVector3 sides = m_upper - m_lower;
	const btScalar slack = was ? kHysteresis * std::max({sides.x(), sides.y(), sides.z()}) : btScalar(0);
	for (int i = 0; i < 3; ++i)
	{
		btScalar lower = std::max(lowerA[i], lowerB[i]), upper = std::min(upperA[i], upperB[i]);
		// Leaves reach out of the boxes: the two may meet where these are apart.
		if (lower > upper) std::swap(lower, upper);
		if (!(std::max(lower, m_lower[i] - slack) <= std::min(upper, m_upper[i] + slack))) return false;
	}
	return true;
}
