// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tree/TreeCheck.h"

#include "BulletISTCollision/Core/Tree/TreeLimits.h"

#include <algorithm>
#include <cmath>

namespace ist
{
namespace
{
bool isFinite(const BoundingBall& b) { return std::isfinite(b.x) && std::isfinite(b.y) && std::isfinite(b.z) && std::isfinite(b.r); }

bool isNear(const BoundingBall& b) { return std::fabs(b.x) + std::fabs(b.y) + std::fabs(b.z) + b.r < kMostReach && b.r >= 0; }

// All operands are floats as stored, so each difference is exact except for one rounding, and kShare covers all roundings. Below
// kSmallestSquare the products lose digits.
constexpr float kShare = 1 + 1e-6f, kSmallestSquare = 1e-30f;

bool surelyInside(const BoundingBall& inner, const BoundingBall& outer)
{
	const float dx = inner.x - outer.x, dy = inner.y - outer.y, dz = inner.z - outer.z;
	const float room = outer.r - inner.r, room2 = room * room;
	return room > 0 && room2 > kSmallestSquare && (dx * dx + dy * dy + dz * dz) * kShare <= room2;
}

/// The same for all balls of a block, given by its first ball.
bool surelyInside(const Sphere* block, const BoundingBall& bound)
{
	int inside = 1;
	for (const Sphere* s = block; s < block + kBlockWidth; ++s)
	{
		const float dx = s->x - bound.x, dy = s->y - bound.y, dz = s->z - bound.z;
		const float room = bound.r - s->r, room2 = room * room;
		inside &= int(room > 0) & int(room2 > kSmallestSquare) & int((dx * dx + dy * dy + dz * dz) * kShare <= room2);
	}
	return inside != 0;
}

/// The same in double, without padding; with the tolerance of BallTree::validate.
bool isInside(const Sphere* block, const BoundingBall& bound)
{
	int inside = 1;
	for (const Sphere* s = block; s < block + kBlockWidth; ++s)
	{
		const Vec3 offset{double(s->x) - bound.x, double(s->y) - bound.y, double(s->z) - bound.z};
		const double room = double(bound.r) * (1 + 1e-12) - s->r;
		inside &= int(s->r == 0) | (int(room >= 0) & int(squaredNorm(offset) <= room * room));
	}
	return inside != 0;
}

/// Depth-first traversal that visits every node and block exactly once.
class Walk
{
public:
	explicit Walk(const BallTree& tree) : m_tree(tree), m_nodeSeen(tree.nodes.size()), m_blockSeen(tree.blockCount()) {}

	bool run()
	{
		m_nodeSeen[0] = 1;
		return visit(0, m_path, 0) && m_nodes == m_tree.nodes.size() && m_blocks == m_tree.blockCount();
	}

private:
	/// `path`: bounds of ancestors that may not contain everything below.
	bool visit(uint32_t index, BoundingBall* path, int depth)
	{
		if (depth >= kMaxTreeDepth) return false;
		++m_nodes;
		const BallNode& node = m_tree.nodes[index];
		for (int k = 0; k < BallNode::kWidth; ++k)
		{
			const BoundingBall bound{node.x[k], node.y[k], node.z[k], node.r[k]};
			const uint32_t child = node.child[k];
			const bool good = child == BallNode::kNoChild ? isFinite(bound) && bound.r == 0
														  : isNear(bound) && descend(child, bound, path, depth + 1);
			if (!good) return false;
		}
		return true;
	}

	bool descend(uint32_t child, const BoundingBall& bound, BoundingBall* path, int depth)
	{
		const uint32_t index = child & ~BallNode::kLeafBit;
		const bool leaf = (child & BallNode::kLeafBit) != 0;
		std::vector<char>& seen = leaf ? m_blockSeen : m_nodeSeen;
		if (index >= seen.size() || seen[index]) return false;
		seen[index] = 1;
		if (leaf)
		{
			++m_blocks;
			// Its own bound may fit too tightly for the test in floats.
			const Sphere* block = m_tree.balls.data() + size_t(index) * kBlockWidth;
			const auto contains = [&](const BoundingBall& o) {
				return surelyInside(bound, o) || surelyInside(block, o) || isInside(block, o);
			};
			return isInside(block, bound) && std::all_of(path, m_end, contains);
		}
		BoundingBall* const end = m_end;
		BoundingBall* const below = end;
		for (const BoundingBall* outer = path; outer != end; ++outer)
			if (!surelyInside(bound, *outer)) *m_end++ = *outer;
		*m_end++ = bound;
		const bool good = visit(index, below, depth);
		m_end = end;
		return good;
	}

	const BallTree& m_tree;
	std::vector<char> m_nodeSeen, m_blockSeen;
	size_t m_nodes = 0, m_blocks = 0;
	// Each level has a list of its own, at most one entry longer than that of the level above.
	BoundingBall m_path[(kMaxTreeDepth + 1) * (kMaxTreeDepth + 2) / 2];
	BoundingBall* m_end = m_path;
};
}  // namespace

bool isOfABody(float density, float depth) { return (density < 4) & (std::fabs(depth) < kMostReach); }

bool hasWholeBlocks(const BallTree& tree)
{
	const size_t slots = tree.slotCount(), ofPacked = tree.ellipsoids.empty() ? slots : 0;
	return slots % kBlockWidth == 0 && tree.ellipsoids.size() == slots - ofPacked && tree.sphereIndex.size() == ofPacked;
}

bool surelyValid(const BallTree& tree, size_t block)
{
	// The sum overflows for balls that are finite but far too large for a body.
	float sum = 0;
	const Sphere* first = tree.balls.data() + block * kBlockWidth;
	const StoredEllipsoid* ellipsoids = tree.ellipsoids.empty() ? nullptr : tree.ellipsoids.data() + block * kBlockWidth;
	const uint32_t count = tree.ballCount(block);
	int good = count >= 1;
	for (uint32_t k = 0; k < uint32_t(kBlockWidth); ++k)
	{
		const Sphere& s = first[k];
		sum += (std::fabs(s.x) + std::fabs(s.y)) + (std::fabs(s.z) + s.r);
		good &= k < count ? int(MomentEllipsoid::isRadius(s.r)) : int(s.r == 0) & int(s.x >= kFarPadding);
	}
	if (!good || !std::isfinite(sum)) return false;
	if (ellipsoids == nullptr) return true;
	for (uint32_t k = 0; k < uint32_t(kBlockWidth); ++k)
	{
		const StoredEllipsoid& e = ellipsoids[k];
		const int solid = int(e.isSolid()) & int(isOfABody(e.density, e.depth)), empty = int(e.density == 0) & int(std::isfinite(e.depth));
		good &= k < count ? solid : empty;
	}
	return good != 0;
}

bool surelyValidNodes(const BallTree& tree) { return !tree.nodes.empty() && !tree.balls.empty() && Walk(tree).run(); }

bool surelyValid(const BallTree& tree)
{
	if (!hasWholeBlocks(tree)) return false;
	for (size_t i = 0; i < tree.blockCount(); ++i)
		if (!surelyValid(tree, i)) return false;
	return surelyValidNodes(tree);
}
}  // namespace ist
