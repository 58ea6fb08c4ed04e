// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/ProximityQuery.h"

#include "BulletISTCollision/Core/Tree/TreeLimits.h"
#include "BulletISTCollision/Core/Tree/TreePose.h"

#include <algorithm>
#include <limits>

namespace ist
{
namespace
{
struct Side
{
	uint32_t id;  ///< node, or block | kLeafBit
	Vec3 center;
	double r;
	bool leaf() const { return (id & BallNode::kLeafBit) != 0; }
	uint32_t block() const { return id & ~BallNode::kLeafBit; }
};

struct Item
{
	Side a, b;
	double bound;  ///< lower bound of the distance of all pairs below
};

class NearestPair
{
public:
	NearestPair(const BallTree& A, const BallTree& B, const Pose& X) : m_A(A), m_B(B), m_X(X) {}

	/// Distance and nearest points in A's tree frame.
	Distance run()
	{
		constexpr double inf = std::numeric_limits<double>::infinity();
		m_stack[m_top++] = {{0, {}, inf}, {0, {}, inf}, 0};
		while (m_top > 0 && m_best > 0)
		{
			const Item item = m_stack[--m_top];
			if (item.bound >= m_best) continue;
			if (item.a.leaf() && item.b.leaf()) blockPair(item);
			else if (item.b.leaf() || (!item.a.leaf() && item.a.r >= item.b.r)) open(item, true);
			else open(item, false);
		}
		return nearest();
	}

private:
	static double gap(const Side& a, const Side& b) { return std::max(0.0, distance(a.center, b.center) - a.r - b.r); }

	void open(const Item& item, bool first)
	{
		const BallNode& node = first ? m_A.nodes[item.a.id] : m_B.nodes[item.b.id];
		const int begin = m_top;
		for (int k = 0; k < BallNode::kWidth; ++k)
		{
			if (node.child[k] == BallNode::kNoChild) continue;
			const Vec3 c{node.x[k], node.y[k], node.z[k]};
			// Poses are rigid only within 1e-4, so the radius gets a margin that keeps the bound valid.
			const Side child{node.child[k], first ? c : m_X * c, first ? node.r[k] : node.r[k] * (1 + 1e-3)};
			Item next{first ? child : item.a, first ? item.b : child, 0};
			next.bound = gap(next.a, next.b);
			if (!(next.bound >= m_best)) m_stack[m_top++] = next;
		}
		// The nearest item is on top of the stack.
		std::sort(m_stack + begin, m_stack + m_top,
			[](const Item& p, const Item& q) { return p.bound != q.bound ? p.bound > q.bound : p.a.r + p.b.r > q.a.r + q.b.r; });
	}

	void blockPair(const Item& item)
	{
		const uint32_t countA = m_A.ballCount(item.a.block()), countB = m_B.ballCount(item.b.block());
		const Sphere* a = m_A.balls.data() + item.a.block() * kBlockWidth;
		const Sphere* b = m_B.balls.data() + item.b.block() * kBlockWidth;
		Vec3 moved[kBlockWidth];
		for (uint32_t j = 0; j < countB; ++j) moved[j] = m_X * b[j].center();
		for (uint32_t i = 0; i < countA; ++i)
		{
			const Vec3 c = a[i].center();
			if (distance(c, item.b.center) - a[i].r - item.b.r >= m_best) continue;
			for (uint32_t j = 0; j < countB; ++j)
			{
				const double gap = distance(c, moved[j]) - a[i].r - b[j].r;
				if (gap >= m_best) continue;
				m_best = gap;
				m_centerA = c;
				m_centerB = moved[j];
				m_radiusA = a[i].r;
				m_radiusB = b[j].r;
			}
		}
	}

	Distance nearest() const
	{
		const Vec3 apart = m_centerB - m_centerA;
		const double length = norm(apart);
		const Vec3 along = length > 0 ? apart / length : Vec3{};
		Distance result;
		result.upper = std::max(0.0, m_best);
		if (m_best > 0)
		{
			result.pointA = m_centerA + along * m_radiusA;
			result.pointB = m_centerB - along * m_radiusB;
			return result;
		}
		// This is the middle of the segment that both spheres share on the line through their centres.
		const double from = std::max(-m_radiusA, length - m_radiusB), to = std::min(m_radiusA, length + m_radiusB);
		result.pointA = result.pointB = m_centerA + along * (0.5 * (from + to));
		return result;
	}

	const BallTree& m_A;
	const BallTree& m_B;
	const Pose& m_X;
	double m_best = std::numeric_limits<double>::infinity();
	Vec3 m_centerA, m_centerB;  ///< centres of the nearest spheres
	double m_radiusA = 0, m_radiusB = 0;
	int m_top = 0;
	Item m_stack[kPairStackSize];
};
}  // namespace

Distance queryDistance(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB)
{
	// Without a rigid pose or without spheres nothing is known, so the widest interval is returned.
	if (!isRigid(X_AB) || A.inner.empty() || B.inner.empty()) return {std::numeric_limits<double>::infinity(), 0, {}, {}};
	const Pose X = treePose(A, B, X_AB);
	Distance result = NearestPair(A.inner, B.inner, X).run();
	result.lower = std::max(0.0, result.upper - A.maxGap - B.maxGap);
	result.pointA += A.origin;
	result.pointB += A.origin;
	return result;
}
}  // namespace ist
