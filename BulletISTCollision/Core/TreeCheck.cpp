// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/TreeCheck.h"

#include "BulletISTCollision/Core/Kernels/TreeLimits.h"

#include <algorithm>
#include <cmath>

namespace ist
{
namespace
{
constexpr int kWidth = BallBlock::kWidth;

struct Bound
{
	float x, y, z, r;
};

bool isFinite(const Bound& b)
{
	return std::isfinite(b.x) && std::isfinite(b.y) && std::isfinite(b.z) && std::isfinite(b.r);
}

bool isNear(const Bound& b)
{
	return std::fabs(b.x) + std::fabs(b.y) + std::fabs(b.z) + b.r < kFarthestBound && b.r >= 0;
}

// All operands are floats as stored, so that each difference is exact but for one rounding: the share covers them all.
// Below the smallest square the products lose digits.
constexpr float kShare = 1 + 1e-6f, kSmallestSquare = 1e-30f;

bool surelyInside(const Bound& inner, const Bound& outer)
{
	const float dx = inner.x - outer.x, dy = inner.y - outer.y, dz = inner.z - outer.z;
	const float room = outer.r - inner.r, room2 = room * room;
	return room > 0 && room2 > kSmallestSquare && (dx * dx + dy * dy + dz * dz) * kShare <= room2;
}

bool surelyInside(const BallBlock& block, const Bound& bound)
{
	int inside = 1;
	for (int k = 0; k < kWidth; ++k)
	{
		const float dx = block.x[k] - bound.x, dy = block.y[k] - bound.y, dz = block.z[k] - bound.z;
		const float room = bound.r - block.R[k], room2 = room * room;
		inside &= int(room > 0) & int(room2 > kSmallestSquare) & int((dx * dx + dy * dy + dz * dz) * kShare <= room2);
	}
	return inside != 0;
}

/// In double, padding left out; the same tolerance as BallTree::validate.
bool isInside(const BallBlock& block, const Bound& bound)
{
	int inside = 1;
	for (int k = 0; k < kWidth; ++k)
	{
		const Vec3 offset{double(block.x[k]) - bound.x, double(block.y[k]) - bound.y, double(block.z[k]) - bound.z};
		const double room = double(bound.r) * (1 + 1e-12) - block.R[k];
		inside &= int(block.R[k] == 0) | (int(room >= 0) & int(squaredNorm(offset) <= room * room));
	}
	return inside != 0;
}

/// Depth-first walk that sees every node and block exactly once.
class Walk
{
public:
	explicit Walk(const BallTree& tree) : m_tree(tree), m_nodeSeen(tree.nodes.size()), m_blockSeen(tree.blocks.size()) {}

	bool run()
	{
		m_nodeSeen[0] = 1;
		return visit(0, m_path, 0) && m_nodes == m_tree.nodes.size() && m_blocks == m_tree.blocks.size();
	}

private:
	/// `path`: bounds on the way here that may cut off a part of what lies below.
	bool visit(uint32_t index, Bound* path, int depth)
	{
		if (depth >= kMaxTreeDepth) return false;
		++m_nodes;
		const BallNode& node = m_tree.nodes[index];
		for (int k = 0; k < BallNode::kWidth; ++k)
		{
			const Bound bound{node.x[k], node.y[k], node.z[k], node.r[k]};
			const uint32_t child = node.child[k];
			const bool good = child == BallNode::kNoChild ? isFinite(bound) && bound.r == 0 : isNear(bound) && descend(child, bound, path, depth + 1);
			if (!good) return false;
		}
		return true;
	}

	bool descend(uint32_t child, const Bound& bound, Bound* path, int depth)
	{
		const uint32_t index = child & ~BallNode::kLeafBit;
		const bool leaf = (child & BallNode::kLeafBit) != 0;
		std::vector<char>& seen = leaf ? m_blockSeen : m_nodeSeen;
		if (index >= seen.size() || seen[index]) return false;
		seen[index] = 1;
		if (leaf)
		{
			++m_blocks;
			// Its own bound fits too tightly for floats to be sure.
			const BallBlock& block = m_tree.blocks[index];
			const auto contains = [&](const Bound& o) { return surelyInside(bound, o) || surelyInside(block, o) || isInside(block, o); };
			return isInside(block, bound) && std::all_of(path, m_end, contains);
		}
		Bound* const end = m_end;
		Bound* const below = end;
		for (const Bound* outer = path; outer != end; ++outer)
			if (!surelyInside(bound, *outer)) *m_end++ = *outer;
		*m_end++ = bound;
		const bool good = visit(index, below, depth);
		m_end = end;
		return good;
	}

	const BallTree& m_tree;
	std::vector<char> m_nodeSeen, m_blockSeen;
	size_t m_nodes = 0, m_blocks = 0;
	// Each level keeps a list of its own, at most one longer than that of the level above.
	Bound m_path[(kMaxTreeDepth + 1) * (kMaxTreeDepth + 2) / 2];
	Bound* m_end = m_path;
};
}  // namespace

bool surelyValid(const BallBlock& block, const MomentEllipsoid* balls)
{
	// Overflows for balls that are finite but of no known world.
	float sum = 0;
	const uint32_t count = block.count();
	int good = count >= 1;
	for (uint32_t k = 0; k < uint32_t(kWidth); ++k)
	{
		const MomentEllipsoid& b = balls[k];
		sum += (std::fabs(b.x) + std::fabs(b.y)) + (std::fabs(b.z) + b.R) + (b.density + std::fabs(b.depth)) +
			   (std::fabs(b.nx) + std::fabs(b.ny) + std::fabs(b.nz)) + (std::fabs(b.xx) + std::fabs(b.yy) + std::fabs(b.zz)) +
			   (std::fabs(b.xy) + std::fabs(b.xz) + std::fabs(b.yz));
		const int solid = int(b.isSolid()), empty = int(b.R == 0) & int(b.density == 0) & int(b.x >= kFarPadding);
		good &= k < count ? solid : empty;
		good &= int(block.x[k] == b.x) & int(block.y[k] == b.y) & int(block.z[k] == b.z) & int(block.R[k] == b.R);
	}
	return good && std::isfinite(sum);
}

bool surelyValid(const BallBlock& block, const Sphere* spheres)
{
	float sum = 0;
	const uint32_t count = block.count();
	int good = count >= 1;
	for (uint32_t k = 0; k < uint32_t(kWidth); ++k)
	{
		const Sphere& s = spheres[k];
		sum += (std::fabs(s.x) + std::fabs(s.y)) + (std::fabs(s.z) + s.r);
		good &= k < count ? int(MomentEllipsoid::isRadius(s.r)) : int(s.r == 0) & int(s.x >= kFarPadding);
		good &= int(block.x[k] == s.x) & int(block.y[k] == s.y) & int(block.z[k] == s.z) & int(block.R[k] == s.r);
	}
	return good && std::isfinite(sum);
}

bool surelyValidNodes(const BallTree& tree)
{
	return !tree.nodes.empty() && Walk(tree).run();
}

bool surelyValid(const BallTree& tree)
{
	const bool packed = !tree.spheres.empty();
	if ((packed ? tree.spheres.size() : tree.balls.size()) != tree.slotCount() || tree.sphereIndex.size() != tree.spheres.size()) return false;
	for (size_t i = 0; i < tree.blocks.size(); ++i)
	{
		const BallBlock& block = tree.blocks[i];
		if (!(packed ? surelyValid(block, tree.spheres.data() + i * kWidth) : surelyValid(block, tree.balls.data() + i * kWidth))) return false;
	}
	return surelyValidNodes(tree);
}
}  // namespace ist
