// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Packing/BallAscent.h"

#include <algorithm>
#include <cmath>

namespace ist
{
namespace
{
constexpr int kMaxSteps = 60;
constexpr size_t kMaxBlockers = 12;
constexpr double kRiseTolerance = 1e-7;  // share of the radius

/// Up to four gradients and their weights in the min-norm point of the convex hull.
struct WorkingSet
{
	int index[4];
	Vec3 gradient[4];
	double weight[4];
	int size = 0;
};

/// Point of smallest norm of the affine hull of the chosen gradients; false unless it lies in their convex hull.
bool affineMinimum(const Vec3* g, int count, Vec3& v, double* w)
{
	if (count == 1)
	{
		v = g[0];
		w[0] = 1;
		return true;
	}
	if (count == 2)
	{
		const Vec3 e = g[1] - g[0];
		const double ee = squaredNorm(e);
		if (!(ee > 1e-24)) return false;
		w[1] = -dot(e, g[0]) / ee;
		w[0] = 1 - w[1];
		v = g[0] + e * w[1];
	}
	else if (count == 3)
	{
		const Vec3 n = cross(g[1] - g[0], g[2] - g[0]);
		const double nn = squaredNorm(n);
		if (!(nn > 1e-24)) return false;
		v = n * (dot(n, g[0]) / nn);
		w[0] = dot(n, cross(g[1] - v, g[2] - v)) / nn;
		w[1] = dot(n, cross(g[2] - v, g[0] - v)) / nn;
		w[2] = 1 - w[0] - w[1];
	}
	else
	{
		w[0] = dot(g[1], cross(g[2], g[3]));
		w[1] = -dot(g[0], cross(g[2], g[3]));
		w[2] = dot(g[0], cross(g[1], g[3]));
		w[3] = -dot(g[0], cross(g[1], g[2]));
		const double sum = w[0] + w[1] + w[2] + w[3];
		if (!(std::fabs(sum) > 1e-14)) return false;
		for (int i = 0; i < 4; ++i) w[i] /= sum;
		v = {};
	}
	for (int i = 0; i < count; ++i)
		if (w[i] < 0) return false;
	return true;
}

/// Min-norm point of the convex hull. Gradients without weight are dropped.
Vec3 minimumNorm(WorkingSet& set)
{
	Vec3 best;
	double bestNorm = 1e300;
	WorkingSet kept;
	// The last gradient was added because it lowers the minimum of the others. So it has weight, except for rounding.
	const unsigned subsets = 1u << set.size, newest = subsets / 2;
	for (unsigned k = 0; k + 1 < subsets && (k < newest || kept.size == 0); ++k)
	{
		const unsigned mask = k < newest ? newest + k : k - newest + 1;
		Vec3 g[4], v;
		double w[4];
		int map[4], count = 0;
		for (int i = 0; i < set.size; ++i)
			if (mask >> i & 1)
			{
				map[count] = i;
				g[count++] = set.gradient[i];
			}
		if (!affineMinimum(g, count, v, w)) continue;
		const double n = squaredNorm(v);
		if (!(n < bestNorm)) continue;
		bestNorm = n;
		best = v;
		kept.size = count;
		for (int i = 0; i < count; ++i)
		{
			kept.index[i] = set.index[map[i]];
			kept.gradient[i] = g[i];
			kept.weight[i] = w[i];
		}
	}
	set = kept;
	return best;
}

/// Largest t with |s + t v| <= limit.
double distanceToRim(const Vec3& s, const Vec3& v, double limit)
{
	const double a = squaredNorm(v), b = dot(s, v), c = squaredNorm(s) - limit * limit;
	const double root = std::sqrt(std::max(0.0, b * b - a * c));
	return std::max(0.0, b > 0 ? -c / (b + root) : (root - b) / a);
}
}  // namespace

BallAscent::Step BallAscent::solve(double trust)
{
	Step step;
	WorkingSet set;
	size_t lowest = 0;
	for (size_t i = 1; i < m_planes.size(); ++i)
		if (m_planes[i].distance < m_planes[lowest].distance) lowest = i;
	step.value = m_planes[lowest].distance;
	const size_t count = m_planes.size();
	for (std::vector<double>* column : {&m_gx, &m_gy, &m_gz, &m_slack, &m_closing}) column->resize(count);
	for (size_t j = 0; j < count; ++j)
	{
		const DistanceOctree::Plane& p = m_planes[j];
		m_gx[j] = p.gradient.x, m_gy[j] = p.gradient.y, m_gz[j] = p.gradient.z;
		m_slack[j] = p.distance - step.value;
	}
	set.index[0] = int(lowest);
	set.gradient[0] = m_planes[lowest].gradient;
	set.size = 1;

	for (int iteration = 0; iteration < 40; ++iteration)
	{
		const Vec3 v = minimumNorm(set);
		const double rate = squaredNorm(v);
		step.active = set.size;
		if (rate < 1e-14) break;
		double t = distanceToRim(step.s, v, trust);
		int next = -1;
		setClosingRates(v, rate);
		for (size_t j = 0; j < count; ++j)
		{
			const double closing = m_closing[j];
			if (m_slack[j] >= t * closing || closing <= 1e-10 * rate + 1e-15) continue;
			bool inSet = false;
			for (int i = 0; i < set.size; ++i) inSet = inSet || set.index[i] == int(j);
			if (inSet) continue;
			t = std::max(0.0, m_slack[j] / closing);
			next = int(j);
		}
		step.s += v * t;
		step.value += rate * t;
		for (size_t j = 0; j < count; ++j) m_slack[j] -= t * m_closing[j];
		if (next < 0)
		{
			step.atRim = true;
			break;
		}
		if (set.size == 4) break;
		set.index[set.size] = next;
		set.gradient[set.size++] = m_planes[next].gradient;
	}
	return step;
}

void BallAscent::setClosingRates(const Vec3& v, double rate)
{
	const size_t count = m_planes.size();
	const double *x = m_gx.data(), *y = m_gy.data(), *z = m_gz.data();
	double* out = m_closing.data();
	for (size_t j = 0; j < count; ++j) out[j] = rate - (x[j] * v.x + y[j] * v.y + z[j] * v.z);
}

void BallAscent::addBlockers(const Vec3& x)
{
	for (const uint32_t item : m_blockers)
		if (std::none_of(m_planes.begin(), m_planes.end(), [item](const DistanceOctree::Plane& p) { return p.item == item; }))
			m_planes.push_back(m_space.plane(item, x));
}

EmptyBall BallAscent::climb(const Vec3& start, DistanceOctree::Nearest at, int& active)
{
	m_blockers.clear();
	EmptyBall ball{start, at.distance};
	if (!(ball.radius > 0)) return ball;
	double trust = 0.5 * ball.radius;
	bool moved = true;
	for (int k = 0; k < kMaxSteps; ++k)
	{
		if (moved)
		{
			m_space.gather(ball.center, at, 2 * trust, m_planes);
			addBlockers(ball.center);
		}
		const Step step = solve(trust);
		active = step.active;
		if (!(step.value > ball.radius * (1 + kRiseTolerance))) break;
		const Vec3 to = ball.center + step.s;
		const DistanceOctree::Nearest there = m_space.nearest(to);
		moved = there.distance > ball.radius && norm(step.s) < ball.radius + there.distance;
		if (moved)
		{
			const double rise = there.distance - ball.radius;
			ball = {to, there.distance};
			at = there;
			if (step.atRim) trust *= 2;
			else trust = std::max(4 * norm(step.s), 1e-3 * ball.radius);
			if (rise < kRiseTolerance * ball.radius) break;
			continue;
		}
		const bool known = there.item == DistanceOctree::kNoItem ||
			std::any_of(m_planes.begin(), m_planes.end(), [&](const DistanceOctree::Plane& p) { return p.item == there.item; });
		if (!known)
		{
			m_planes.push_back(m_space.plane(there.item, ball.center));
			if (m_blockers.size() == kMaxBlockers) m_blockers.erase(m_blockers.begin());
			m_blockers.push_back(there.item);
			continue;
		}
		trust *= 0.4;
		if (trust < 1e-6 * ball.radius) break;
	}
	return ball;
}

EmptyBall BallAscent::grow(const Vec3& start, const DistanceOctree::Nearest& at, const Vec3& away)
{
	int active = 0;
	EmptyBall ball = climb(start, at, active);
	if (!(ball.radius > 0) || active >= 4) return ball;
	// A ball that fewer than four items hold may sit on a saddle, for example midway between two balls.
	const Vec3 aside = ball.center + away * (0.1 * ball.radius);
	const EmptyBall other = climb(aside, m_space.nearest(aside), active);
	return other.radius > ball.radius ? other : ball;
}
}  // namespace ist
