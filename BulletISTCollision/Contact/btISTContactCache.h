// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include <array>
#include <cstdint>

struct btISTContact;

/// Settings of the contact cache: which queries a world may skip.
struct btISTContactCache
{
	/// False: every pair that Bullet hands over is queried in every step.
	bool on = true;
	/// Largest error that cached results may add to the force of a pair, 0 to 0.5. It is a share of the larger of the force and the force
	/// floor (ist::forceFloor, k times 0.1 % of the smaller body's volume). The limit is measured, not proved: for wedged thin bodies it
	/// was once exceeded tenfold.
	/// With 0 a result is reused only if it is exactly what the query would find: the world moves, bit for bit, as without a contact
	/// cache. With btISTRegistration::setVerletLists it moves so except for the rounding of floats and the patches, because a Verlet list
	/// does not notice the motion of skipped queries.
	double maxError = 0;
};

using btISTEconomy [[deprecated("since 0.3: btISTContactCache")]] = btISTContactCache;

/// Number and cost of the queries of one pair, or of all pairs, and the number of queries that the contact cache saved.
struct btISTQueryCost
{
	uint64_t asked = 0;        ///< number of queries
	uint64_t cachedApart = 0;  ///< number of results reused because the leaves cannot have met since the last query
	uint64_t cachedStill = 0;  ///< number of results reused because the two have not moved relative to each other since the step before
	uint64_t cachedMoved = 0;  ///< number of results reused because the motion was so small that the corrected result is within the
							   ///< tolerance
	int64_t nodeVisits = 0, ballTests = 0, leafPairs = 0;  ///< cost of the queries in units that do not depend on the machine, and the leaf
														   ///< pairs that they found
	double seconds = 0;       ///< time of queries and of reused results, counted while the store measures query time [s]
	double querySeconds = 0;  ///< time of queries alone, counted likewise [s]
	/// Largest relative force error of a cached result, measured whenever the pair is queried again. It includes results up to twice
	/// beyond the limit of reuse. Same reference force as btISTContactCache::maxError.
	double largestCacheError = 0;

	uint64_t cached() const { return cachedApart + cachedStill + cachedMoved; }
	/// Steps per query, summed over pairs; 1 without a contact cache.
	double factor() const { return asked > 0 ? double(asked + cached()) / double(asked) : 1; }
};

/// The last result of a pair, reused as long as it is accurate enough. All decisions compare poses, not velocities. So a body that is
/// teleported, moved as a kinematic body, or woken elsewhere is queried again.
///
/// While the bodies are apart, the result is reused until a point of one may have approached the other by the clearance that the query
/// left (LeafClearance.h). While they touch, the pair is queried again in three cases: the sum over the patches of the first-order force
/// change exceeds a quarter of the tolerance; the rotation does; or the bodies have moved at the rim of the contact by a quarter of the sum
/// of their errorLength(), or, if surfaces touch and that is less, by the tolerance's share of the depth. The last limit exists because
/// what does not touch yet, and what parts, is not foreseen. A reused result follows the motion to first order (RelativeMotion.h). Its
/// error is measured at the next query. If it exceeds half of the tolerance, the pair's limits are halved; they grow again slowly.
class btISTCachedResult
{
public:
	enum Use
	{
		Ask,
		Apart,
		Still,
		Moved
	};
	static constexpr int kMaxPatches = 8;

	/// Quantities on which a result depends besides pose and options. If B is a closed form, its numbers; for two trees with a tolerance,
	/// A's weight, by which their level was chosen; otherwise zero.
	using Measures = std::array<double, 4>;

	/// Decides what to do at the pose `contact.X_AB`, by the weights of the step before. With Moved, the sums of `contact` follow the
	/// motion; with Ask they do, too, if there is a result to compare with. `version`: version of the query options. O(patches), no
	/// allocation.
	Use use(btISTContact& contact, const Measures& measures, uint64_t version, const btISTContactCache& contactCache);
	/// Stores the result of a query, whose sums are in `contact` now. `clearance`: clearance of the leaves if none meet.
	void keep(
		const btISTContact& contact, const Measures& measures, uint64_t version, double clearance, const btISTContactCache& contactCache);
	void forget()
	{
		m_valid = false;
		m_foundError = 0;
	}
	/// Whether the clearance after the next query is worth its cost. It is seldom so while the clearance is used up in every step.
	bool wantsClearance();
	/// Force floor: k times ist::forceFloor [N]. Smaller forces are judged as if they were this large.
	static double floorForce(const btISTContact& contact);
	/// Relative error of the cached result before the last `keep`; 0 if there was none. See btISTQueryCost::largestCacheError.
	double foundError() const { return m_foundError; }

private:
	bool isFar(const btISTContact& contact) const;
	bool follow(btISTContact& contact, double tolerance);
	double change(const btISTContact& contact) const;
	void judge(const btISTContact& contact, double granted);

	ist::Pose m_X_asked, m_X_last;
	ist::Wrench m_normalA[kMaxPatches], m_normalB[kMaxPatches];  // wrenches of the patches at the query
	ist::Vec3 m_predicted;                                       // force for k = 1, A's mesh axes
	Measures m_measures{};
	uint64_t m_version = 0;
	double m_clearance = 0;
	double m_trust = 1, m_foundError = 0;
	bool m_valid = false, m_hasPrediction = false;
	uint8_t m_pause = 0, m_skipped = 0;  // m_pause: number of queries without a clearance after each one with it; m_skipped: how many of
										 // them there were
};
