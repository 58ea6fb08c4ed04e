// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Query/VerletList.h"

#include <algorithm>
#include <vector>

namespace ist
{
/// Pose of B seen from A, and a ball that contains B. Together they bound the motion of B's points.
struct SeenPose
{
	Pose X;            ///< pose of B's tree frame in A's
	Vec3 center;       ///< centre of a ball around B, in B's tree frame
	double reach = 0;  ///< radius of that ball [m]
	/// Upper bound of the motion of any point of that ball [m].
	double motionTo(const Pose& other) const;
	/// Pose after a drift of the ball's centre [m] and a turn about it (rotation vector [rad]), in A's axes.
	Pose moved(const Vec3& drift, const Vec3& turn) const;
};

/// State of VerletList.
struct VerletList::Implementation
{
	explicit Implementation(int pairs);

	/// Forgets the pairs and also the bodies. The last pose says nothing about the motion of the next bodies, even if these have the
	/// same trees.
	void forget();
	/// Whether the remembered pairs are valid for this query. Also updates the estimate of the motion.
	bool covers(const BallTree& A, const BallTree& B, const QueryOptions& options, const SeenPose& now);
	/// Margin with which to fill the list [m]. 0 means that this query should not fill it.
	double marginToFill() const;
	/// Pose around which to fill the list: the last pose, moved ahead by half of the motion expected while the margin lasts. So the
	/// list lasts twice as long.
	Pose poseToFill(double margin) const;
	/// Starts filling the list with the pairs that come within `margin` at `X`.
	void begin(double margin, const Pose& X);
	void append(const uint32_t* pairA, const uint32_t* pairB, int number);
	/// Adapts the margin. Call it after each search; `found` is the number of pairs that intersect.
	void end(int64_t found);

	/// Array for the patch of each remembered pair, which `divide` reads.
	uint8_t* patchOf() { return m_patchOf.data(); }
	/// Sorts the pairs by their patches and keeps their order within each patch. There are at most kMostPatches.
	void divide(int patches);
	/// Number of patches into which the pairs are divided; 0: they are not divided.
	int patches() const { return m_patches; }
	/// Stores the integrals of the patches of the query whose pairs were grouped.
	void note(const OverlapIntegrals* patches, int number) { m_grouped = Grouping(patches, number); }
	/// Whether patches with these integrals are still a valid grouping: about as many pairs intersect, and the normals within patches
	/// cancel hardly more.
	bool isGrouping(const OverlapIntegrals* patches, int number) const;
	void dropPatches() { m_patches = 0; }
	size_t firstOf(int patch) const { return m_first[patch]; }

	static constexpr int kMostPatches = 64;
	std::vector<uint32_t> a, b;  ///< indices of balls
	size_t count = 0;
	bool valid = false;

private:
	void learnMotion(const SeenPose& now);
	/// Part of the margin that one query uses up when the list is filled ahead of the motion [m].
	double pace() const { return std::min(m_step, 0.5 * m_step + m_swerve); }

	struct Grouping
	{
		Grouping() = default;
		Grouping(const OverlapIntegrals* patches, int number);
		int64_t pairs = 0;
		double volume = 0, aligned = 0;  ///< volume, and what is left of it when normals cancel within each patch [m^3]
	};

	const BallTree *m_A = nullptr, *m_B = nullptr;
	size_t m_ballsA = 0, m_ballsB = 0;
	Model m_model = Model::Law;
	bool m_bounds = false;  ///< whether the list includes pairs that meet only with their bounding balls
	SeenPose m_filled, m_last;
	double m_margin = 0;  ///< margin of the remembered pairs [m]
	double m_most = 0;    ///< largest margin to use, adapted by `end` [m]
	double m_step = -1;   ///< recent motion from query to query [m]; negative: not known yet
	double m_swerve = 0;  ///< recent deviation of the motion from `m_drift` and `m_turn` [m]
	/// recent motion of B's ball from query to query: drift of its centre [m] and turn (rotation vector [rad]), in A's axes
	Vec3 m_drift, m_turn;
	std::vector<uint8_t> m_patchOf;
	std::vector<uint32_t> m_sortedA, m_sortedB;  ///< working arrays of `divide`
	size_t m_first[kMostPatches + 1] = {};
	int m_patches = 0;
	Grouping m_grouped;
	bool m_full = false;  ///< whether intersecting pairs leave too little room for a margin
};
}  // namespace ist
