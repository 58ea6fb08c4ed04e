// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include "LinearMath/btVector3.h"

#include <optional>
#include <utility>
#include <vector>

class btCollisionObject;
struct btCollisionObjectWrapper;

/// Filter that says which pairs, and which part of the world, have volumetric contact; by default all. Bullet handles all other pairs,
/// with or without trees. A change takes effect in the next step in which Bullet processes the pair. The contact points change hands with
/// the pair, so that none is lost or counted twice. Between steps only; one owner thread, the world's.
class btISTPairFilter
{
public:
	/// From the first call on, only the pairs named here are volumetric. The order of the two objects does not matter. Remove a pair
	/// before one of the two is deleted, because its address may be given to a new object.
	void addPair(const btCollisionObject* a, const btCollisionObject* b);
	/// After the last pair is removed, no pair is volumetric until `acceptAllPairs`.
	void removePair(const btCollisionObject* a, const btCollisionObject* b);
	void acceptAllPairs();

	/// Only pairs that can meet inside this box (World) are volumetric: those whose bounding boxes share a point of it, or
	/// have a point of it between them, because leaves reach beyond the boxes. Such a pair stays
	/// volumetric until the intersection of its bounding boxes has left the enlarged box. Enlarged means by a twentieth of the longest
	/// side on every side. Refused if the corners are not finite or `lower` exceeds `upper`.
	std::optional<ist::Error> setRegion(const btVector3& lower, const btVector3& upper);
	void clearRegion() { m_hasRegion = false; }

	/// Whether the named pairs include this pair. O(log pairs), no allocation.
	bool acceptsPair(const btCollisionObject* a, const btCollisionObject* b) const;
	/// Whether the region includes the pair. `lower` and `upper` are the corners of the bounding boxes of both (World).
	bool acceptsBoxes(const btVector3& lowerA, const btVector3& upperA, const btVector3& lowerB, const btVector3& upperB, bool was) const;
	/// Whether the pair is to be volumetric. `was`: it is volumetric now. O(log pairs), no allocation.
	bool accepts(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b, bool was) const;

	// Former names, kept until 0.4.
	[[deprecated("since 0.3: addPair")]] void watchPair(const btCollisionObject* a, const btCollisionObject* b) { addPair(a, b); }
	[[deprecated("since 0.3: removePair")]] void unwatchPair(const btCollisionObject* a, const btCollisionObject* b) { removePair(a, b); }
	[[deprecated("since 0.3: acceptAllPairs")]] void watchAllPairs() { acceptAllPairs(); }
	[[deprecated("since 0.3: setRegion")]] std::optional<ist::Error> watchRegion(const btVector3& lower, const btVector3& upper)
	{
		return setRegion(lower, upper);
	}
	[[deprecated("since 0.3: clearRegion")]] void watchEverywhere() { clearRegion(); }

private:
	using Pair = std::pair<const btCollisionObject*, const btCollisionObject*>;
	static Pair sorted(const btCollisionObject* a, const btCollisionObject* b);

	std::vector<Pair> m_pairs;  // sorted
	bool m_onlyPairs = false, m_hasRegion = false;
	btVector3 m_lower{0, 0, 0}, m_upper{0, 0, 0};
};
using btISTWatch [[deprecated("since 0.3: btISTPairFilter")]] = btISTPairFilter;
