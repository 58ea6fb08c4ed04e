// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Packing/DistanceOctree.h"

#include <cstdint>
#include <vector>

namespace ist
{
/// A candidate: the largest empty ball about `center`.
struct EmptyBall
{
	Vec3 center;
	double radius = 0;
};

/// Moves an empty ball uphill on f until it touches its neighbours on all sides. Each step maximises the smallest linearised distance
/// within a trust radius D. This is a lower bound of f(x + s), so f rises in every step, and the path stays in the component of the empty
/// space where it began. One object per thread.
class BallAscent
{
public:
	explicit BallAscent(DistanceOctree& space) : m_space(space) {}

	/// Grows a ball from `start`, which must lie in the empty space; radius <= 0 otherwise. `at`: nearest() at `start`. `away` (unit
	/// length): direction of a second try if fewer than four items hold the ball.
	EmptyBall grow(const Vec3& start, const DistanceOctree::Nearest& at, const Vec3& away);

private:
	struct Step
	{
		Vec3 s;
		double value = 0;    ///< min of the linearised distances at s
		int active = 0;      ///< number of items that hold the ball if it cannot rise, at most four
		bool atRim = false;  ///< |s| = D
	};

	EmptyBall climb(const Vec3& start, DistanceOctree::Nearest at, int& active);
	Step solve(double trust);
	void setClosingRates(const Vec3& v, double rate);  ///< for a ball that moves by v and grows by `rate`
	void addBlockers(const Vec3& x);

	DistanceOctree& m_space;
	std::vector<DistanceOctree::Plane> m_planes;
	std::vector<double> m_gx, m_gy, m_gz;    ///< gradients of the planes
	std::vector<double> m_slack, m_closing;  ///< per plane: its height above the ball's, and the rate at which that height falls
	std::vector<uint32_t> m_blockers;        ///< nearest items at rejected points that the leaf of x does not list
};
}  // namespace ist
