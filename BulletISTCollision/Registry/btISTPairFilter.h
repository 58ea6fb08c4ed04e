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

/// Which pairs, and which part of the world, deserve volumetric contact; to begin with all of it. Everything else is Bullet's, trees or no
/// trees. A change takes effect in the next step in which Bullet looks at the pair: it changes hands with its contact points, so that
/// nothing is lost or counted twice. Between steps only; one owner thread, that of the world.
class btISTPairFilter
{
public:
	/// From the first call on only the pairs named here, in any order of the two, are volumetric. Unwatch a pair before one of the
	/// two is deleted: its address may be given to a new one.
	void addPair(const btCollisionObject* a, const btCollisionObject* b);
	/// Without any pair left nothing is volumetric, until `acceptAllPairs`.
	void removePair(const btCollisionObject* a, const btCollisionObject* b);
	void acceptAllPairs();

	/// Only pairs that can meet inside of this box (World) are volumetric: those whose bounding boxes share a point of it. Such a pair
	/// stays so until what its bounding boxes share has left the box enlarged by a twentieth of its longest side to every side. Refused
	/// when not finite or turned inside out.
	std::optional<ist::Error> setRegion(const btVector3& lower, const btVector3& upper);
	void clearRegion() { m_hasRegion = false; }

	/// As far as pairs were named. O(log pairs), no allocation.
	bool acceptsPair(const btCollisionObject* a, const btCollisionObject* b) const;
	/// As far as the region goes: `lower` and `upper` corners of the bounding boxes of both (World).
	bool acceptsBoxes(const btVector3& lowerA, const btVector3& upperA, const btVector3& lowerB, const btVector3& upperB, bool was) const;
	/// `was`: it is volumetric now. O(log pairs), no allocation.
	bool covers(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b, bool was) const;

	// Former names, until 0.4.
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
