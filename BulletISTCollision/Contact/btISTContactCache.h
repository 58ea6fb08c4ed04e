// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include <array>
#include <cstdint>

struct btISTContact;

/// What a world may leave out of its queries.
struct btISTContactCache
{
	/// False: every pair that Bullet hands over is queried in every step.
	bool on = true;
	/// Error of a pair's force that results kept from former steps may add, as a share of the larger of the force and the floor
	/// (ist::forceFloor, k times 0.1 % of the smaller body's volume); 0 to 0.5. Measured, not proved: where thin bodies are wedged it was
	/// once exceeded tenfold. With 0 only what is exactly what the query would find is kept: the world moves as without contact cache, bit
	/// for bit; with btISTRegistration::setVerletLists but for the rounding of floats and the patches, since what was not asked tells a
	/// memory of no motion.
	double maxError = 0;
};

using btISTEconomy [[deprecated("since 0.3: btISTContactCache")]] = btISTContactCache;

/// What the queries of one pair, or of all pairs, cost and saved.
struct btISTQueryCost
{
	uint64_t asked = 0;        ///< queries
	uint64_t cachedApart = 0;  ///< none, because the leaves cannot have met since the last
	uint64_t cachedStill = 0;  ///< none, because the two have not moved relative to each other since the step before
	uint64_t cachedMoved = 0;  ///< none, because the bodies moved so little that the former result says enough
	int64_t nodeVisits = 0, ballTests = 0, leafPairs = 0;  ///< of the queries: work independent of the machine, and what they found
	double seconds = 0;       ///< while the store measures query time: of queries, and of what was done instead
	double querySeconds = 0;  ///< of queries alone
	/// Largest error of the force that a kept result would have had where the pair was queried again, up to twice as far as it was kept;
	/// as a share of what btISTContactCache::maxError is a share of.
	double largestCacheError = 0;

	uint64_t cached() const { return cachedApart + cachedStill + cachedMoved; }
	/// Steps of pairs for each query; 1 without contact cache.
	double factor() const { return asked > 0 ? double(asked + cached()) / double(asked) : 1; }
};

/// The last answer of a pair, for as long as it says enough. Everything is decided from the poses themselves, not from velocities: what is
/// teleported, moved as a kinematic body, or woken elsewhere, is queried again.
///
/// While apart: until a point of one body may have come nearer to the other by the clearance that the query left (LeafClearance.h). While
/// touching: until the first-order change of the forces of all patches, added up, or the rotation, exceeds half of the error that was
/// granted, or the bodies have moved a quarter of the sum of their errorLength(): surfaces that do not touch yet are not foreseen, and
/// within that length leaves blur them. The result follows the motion to first order (RelativeMotion.h). What it was wrong by is measured
/// at the next query; where that is more than half of what was granted, the pair's bounds are halved, and grow again slowly.
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

	/// What an answer depends on besides pose and options: the numbers that B's closed form is made of; of two trees with an accepted
	/// error, A's weight, by which their level was chosen; else zero.
	using Measures = std::array<double, 4>;

	/// What to do at the pose `contact.X_AB`, by the weights of the step before. With Moved, and with Ask where there was something to be
	/// compared with, the sums of `contact` have followed. `version` of the options of queries. O(patches), no allocation.
	Use use(btISTContact& contact, const Measures& measures, uint64_t version, const btISTContactCache& contactCache);
	/// After a query whose sums are in `contact` now. `clearance`: of leaves, when there are none.
	void keep(
		const btISTContact& contact, const Measures& measures, uint64_t version, double clearance, const btISTContactCache& contactCache);
	void forget()
	{
		m_valid = false;
		m_foundError = 0;
	}
	/// Whether the clearance after the query to come is worth its cost: seldom asked for while it is used up in every step.
	bool wantsClearance();
	/// k times ist::forceFloor [N]: smaller forces are judged as if they were as large.
	static double floorForce(const btISTContact& contact);
	/// What the last `keep` found the result before it to have been wrong by; 0 where there was none. See
	/// btISTQueryCost::largestCacheError.
	double foundError() const { return m_foundError; }

private:
	bool isFar(const btISTContact& contact) const;
	bool follow(btISTContact& contact, double allowed);
	double change(const btISTContact& contact) const;
	void judge(const btISTContact& contact, double granted);

	ist::Pose m_X_asked, m_X_last;
	ist::Wrench m_normalA[kMaxPatches], m_normalB[kMaxPatches];  // of the patches, as they were found
	ist::Vec3 m_predicted;                                       // force with k = 1, A's mesh axes
	Measures m_measures{};
	uint64_t m_version = 0;
	double m_clearance = 0;
	double m_trust = 1, m_foundError = 0;
	bool m_valid = false, m_hasPrediction = false;
	uint8_t m_pause = 0, m_skipped = 0;  // queries without a clearance after each with one; of those, how many there were
};
