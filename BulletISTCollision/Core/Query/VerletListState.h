// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Query/VerletList.h"

#include <algorithm>
#include <vector>

namespace ist
{
/// Where B was seen from A, and the ball that holds it there, for bounds on the motion of its points.
struct SeenPose
{
	Pose X;       ///< of B's tree frame in A's
	Vec3 center;  ///< of a ball around B, in B's tree frame
	double reach = 0;
	/// No point of that ball has moved further [m].
	double motionTo(const Pose& other) const;
	/// The pose after a drift of the ball's center and a turn about it.
	Pose moved(const Vec3& drift, const Vec3& turn) const;
};

/// What VerletList owns.
struct VerletList::Implementation
{
	explicit Implementation(int pairs);

	/// The bodies, too: where they were last is no motion of the next ones, though these may have the same trees.
	void forget();
	/// Whether what is remembered holds for this query; learns from its motion.
	bool covers(const BallTree& A, const BallTree& B, const QueryOptions& options, const SeenPose& now);
	/// The margin to fill the memory with [m]; 0: this query had better not.
	double marginToFill() const;
	/// Where to fill it: half of the way that the motion of late will take while the margin lasts, so that it lasts twice as long.
	Pose poseToFill(double margin) const;
	/// Begins to fill it with what comes within `margin` at `X`.
	void begin(double margin, const Pose& X);
	void append(const uint32_t* pairA, const uint32_t* pairB, int number);
	/// After each search; `found`: the pairs that intersect.
	void end(int64_t found);

	/// Room for the patch of each remembered pair, for `divide`.
	uint8_t* patchOf() { return m_patchOf.data(); }
	/// Sorts the pairs by their patches, and keeps their order within each. At most kMostPatches.
	void divide(int patches);
	/// Into how many patches the pairs are divided; 0: not.
	int patches() const { return m_patches; }
	/// What the patches came to in the query whose pairs were grouped.
	void note(const OverlapIntegrals* patches, int number) { m_grouped = Grouping(patches, number); }
	/// Whether patches that come to this now are still a grouping: about as many pairs intersect, and each patch presses in one direction
	/// as it did.
	bool isGrouping(const OverlapIntegrals* patches, int number) const;
	void dropPatches() { m_patches = 0; }
	size_t firstOf(int patch) const { return m_first[patch]; }

	static constexpr int kMostPatches = 64;
	std::vector<uint32_t> a, b;  ///< indices of balls
	size_t count = 0;
	bool valid = false;

private:
	void learnMotion(const SeenPose& now);
	/// Margin that a query uses up, with the memory filled ahead of the motion [m].
	double pace() const { return std::min(m_step, 0.5 * m_step + m_swerve); }

	struct Grouping
	{
		Grouping() = default;
		Grouping(const OverlapIntegrals* patches, int number);
		int64_t pairs = 0;
		double volume = 0, aligned = 0;  ///< what is left of the volume when normals cancel within each patch [m^3]
	};

	const BallTree *m_A = nullptr, *m_B = nullptr;
	size_t m_ballsA = 0, m_ballsB = 0;
	Model m_model = Model::Law;
	bool m_bounds = false;  ///< pairs whose bounding balls meet count, too
	SeenPose m_filled, m_last;
	double m_margin = 0;   ///< of what is remembered [m]
	double m_most = 0;     ///< largest margin that pays, as far as is known [m]
	double m_step = -1;    ///< motion from query to query, lately [m]; negative: not known yet
	double m_swerve = 0;   ///< by how much that differed from `m_drift`, lately [m]
	Vec3 m_drift, m_turn;  ///< of B's ball from query to query, lately: of its center [m], and as a rotation vector, axes of A
	std::vector<uint8_t> m_patchOf;
	std::vector<uint32_t> m_sortedA, m_sortedB;  ///< of `divide`
	size_t m_first[kMostPatches + 1] = {};
	int m_patches = 0;
	Grouping m_grouped;
	bool m_full = false;  ///< what intersects leaves too little room for a margin
};
}  // namespace ist
