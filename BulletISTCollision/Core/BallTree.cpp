// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/BallTree.h"

#include "BulletISTCollision/Core/Kernels/TreeLimits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace ist
{
namespace
{
// Squares of differences of such coordinates still fit in a float.
constexpr float kFarAway = 1e17f;

struct Bound
{
	float x, y, z, r;
};

/// Binary tree over ranges of the final ball order; children of -1: one block.
struct BinaryNode
{
	int begin = 0, end = 0;
	int left = -1, right = -1;
	Bound bound{};
};

class Builder
{
public:
	explicit Builder(const std::vector<MomentBall>& balls) : m_balls(balls), m_side(balls.size()), m_buffer(balls.size())
	{
		for (int axis = 0; axis < 3; ++axis)
		{
			m_order[axis].resize(balls.size());
			std::iota(m_order[axis].begin(), m_order[axis].end(), 0);
			// The index breaks ties, so that the tree does not depend on the sort.
			std::sort(m_order[axis].begin(), m_order[axis].end(), [&](int a, int b) {
				const double ca = balls[a].center()[axis], cb = balls[b].center()[axis];
				return ca != cb ? ca < cb : a < b;
			});
		}
		m_cost.resize(balls.size() / BallBlock::kWidth + 2);
		m_root = split(0, int(balls.size()));
	}

	BallTree collapse()
	{
		m_tree.nodes.emplace_back();
		fillNode(0, m_root);
		return std::move(m_tree);
	}

private:
	int split(int begin, int end);
	bool bestSplit(int begin, int end, int& bestAxis, int& bestSplit);
	void partition(int begin, int end, int axis, int middle);
	Bound bound(int begin, int end) const;
	void fillNode(uint32_t node, int binary);
	uint32_t makeBlock(const BinaryNode& leaf);

	struct Extent
	{
		Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
		void add(const MomentBall& b)
		{
			const Vec3 c = b.center(), r{b.R, b.R, b.R};
			low = componentMin(low, c - r);
			high = componentMax(high, c + r);
		}
		double cost(int count) const
		{
			const double d = norm(high - low);
			return count * d * d * d;
		}
	};

	const std::vector<MomentBall>& m_balls;
	std::vector<int> m_order[3];
	std::vector<char> m_side;
	std::vector<int> m_buffer;
	std::vector<double> m_cost;
	std::vector<BinaryNode> m_binary;
	BallTree m_tree;
	int m_root = -1;
};

bool Builder::bestSplit(int begin, int end, int& bestAxis, int& bestSplit)
{
	constexpr int W = BallBlock::kWidth;
	const int count = end - begin, blocks = (count + W - 1) / W;
	if (blocks < 2) return false;
	// A quarter on either side at least: bounds the depth whatever the cloud.
	const int first = std::max(1, blocks / 4), last = std::min(blocks - 1, blocks - blocks / 4);
	double best = std::numeric_limits<double>::infinity();
	bestAxis = 0;
	bestSplit = begin + first * W;
	for (int axis = 0; axis < 3; ++axis)
	{
		const int* order = m_order[axis].data() + begin;
		Extent right;
		for (int i = count - 1; i >= first * W; --i)
		{
			right.add(m_balls[order[i]]);
			if (i % W == 0) m_cost[i / W] = right.cost(count - i);
		}
		Extent left;
		for (int i = 0; i < last * W; ++i)
		{
			left.add(m_balls[order[i]]);
			const int k = (i + 1) / W;
			if ((i + 1) % W != 0 || k < first) continue;
			const double cost = left.cost(i + 1) + m_cost[k];
			if (cost < best)
			{
				best = cost;
				bestAxis = axis;
				bestSplit = begin + i + 1;
			}
		}
	}
	return true;
}

void Builder::partition(int begin, int end, int axis, int middle)
{
	for (int i = begin; i < end; ++i) m_side[m_order[axis][i]] = i >= middle;
	for (int other = 0; other < 3; ++other)
	{
		if (other == axis) continue;
		int low = begin, high = middle;
		for (int i = begin; i < end; ++i)
		{
			const int ball = m_order[other][i];
			m_buffer[m_side[ball] ? high++ : low++] = ball;
		}
		std::copy(m_buffer.begin() + begin, m_buffer.begin() + end, m_order[other].begin() + begin);
	}
}

/// Badoiu and Clarkson's iteration: step towards the farthest ball, ever shorter.
Bound Builder::bound(int begin, int end) const
{
	const int* order = m_order[0].data();
	Extent box;
	for (int i = begin; i < end; ++i) box.add(m_balls[order[i]]);
	Vec3 c = (box.low + box.high) / 2, bestCenter = c;
	double best = std::numeric_limits<double>::infinity();
	for (int step = 0; step < 48; ++step)
	{
		double reach = 0;
		Vec3 toFarthest;
		for (int i = begin; i < end; ++i)
		{
			const MomentBall& b = m_balls[order[i]];
			const Vec3 offset = b.center() - c;
			const double d = norm(offset);
			if (d + b.R <= reach) continue;
			reach = d + b.R;
			toFarthest = offset;
		}
		if (reach < best)
		{
			best = reach;
			bestCenter = c;
		}
		c += toFarthest * (1.0 / (step + 4));
	}
	Bound result{float(bestCenter.x), float(bestCenter.y), float(bestCenter.z), 0};
	const Vec3 rounded{result.x, result.y, result.z};
	double reach = 0;
	for (int i = begin; i < end; ++i)
		reach = std::max(reach, distance(m_balls[order[i]].center(), rounded) + m_balls[order[i]].R);
	result.r = std::nextafter(float(reach * (1 + 1e-12)), std::numeric_limits<float>::infinity());
	return result;
}

int Builder::split(int begin, int end)
{
	const int index = int(m_binary.size());
	m_binary.emplace_back();
	int axis, middle, left = -1, right = -1;
	if (bestSplit(begin, end, axis, middle))
	{
		partition(begin, end, axis, middle);
		left = split(begin, middle);
		right = split(middle, end);
	}
	m_binary[index] = {begin, end, left, right, bound(begin, end)};
	return index;
}

uint32_t Builder::makeBlock(const BinaryNode& leaf)
{
	constexpr int W = BallBlock::kWidth;
	BallBlock block;
	block.count = uint32_t(leaf.end - leaf.begin);
	block.bx = leaf.bound.x;
	block.by = leaf.bound.y;
	block.bz = leaf.bound.z;
	block.br = leaf.bound.r;
	for (int k = 0; k < W; ++k)
	{
		MomentBall ball;
		ball.x = ball.y = ball.z = kFarAway;
		if (k < int(block.count)) ball = m_balls[m_order[0][leaf.begin + k]];
		block.x[k] = ball.x;
		block.y[k] = ball.y;
		block.z[k] = ball.z;
		block.R[k] = ball.R;
		m_tree.balls.push_back(ball);
	}
	m_tree.blocks.push_back(block);
	return uint32_t(m_tree.blocks.size() - 1);
}

void Builder::fillNode(uint32_t node, int binary)
{
	int children[BallNode::kWidth] = {binary};
	int count = 1;
	while (count < BallNode::kWidth)
	{
		int widest = -1;
		for (int k = 0; k < count; ++k)
			if (m_binary[children[k]].left >= 0 &&
				(widest < 0 || m_binary[children[k]].bound.r > m_binary[children[widest]].bound.r))
				widest = k;
		if (widest < 0) break;
		const BinaryNode& open = m_binary[children[widest]];
		children[count++] = open.right;
		children[widest] = open.left;
	}
	for (int k = 0; k < BallNode::kWidth; ++k)
	{
		Bound b{kFarAway, kFarAway, kFarAway, 0};
		uint32_t child = BallNode::kNoChild;
		if (k < count)
		{
			const BinaryNode& source = m_binary[children[k]];
			b = source.bound;
			if (source.left < 0)
				child = makeBlock(source) | BallNode::kLeafBit;
			else
			{
				child = uint32_t(m_tree.nodes.size());
				m_tree.nodes.emplace_back();
				fillNode(child, children[k]);
			}
		}
		BallNode& target = m_tree.nodes[node];
		target.x[k] = b.x;
		target.y[k] = b.y;
		target.z[k] = b.z;
		target.r[k] = b.r;
		target.child[k] = child;
	}
}

bool finite(const MomentBall& b)
{
	return isFinite(b.center()) && isFinite(b.normal()) && std::isfinite(b.R) && std::isfinite(b.density) &&
		   std::isfinite(b.depth);
}

bool inside(const Bound& bound, const MomentBall& ball)
{
	return distance({bound.x, bound.y, bound.z}, ball.center()) + ball.R <= double(bound.r) * (1 + 1e-12);
}

std::string violation(const char* what, size_t index) { return std::string(what) + " (index " + std::to_string(index) + ")"; }

std::string checkBlock(const BallTree& tree, uint32_t index, const std::vector<Bound>& path)
{
	constexpr int W = BallBlock::kWidth;
	const BallBlock& block = tree.blocks[index];
	if (block.count < 1 || block.count > uint32_t(W)) return violation("block count out of range", index);
	const Bound own{block.bx, block.by, block.bz, block.br};
	if (!isFinite(Vec3{own.x, own.y, own.z}) || !std::isfinite(own.r)) return violation("block bound not finite", index);
	for (int k = 0; k < W; ++k)
	{
		const MomentBall& ball = tree.balls[size_t(index) * W + k];
		if (!finite(ball)) return violation("ball not finite", size_t(index) * W + k);
		if (block.x[k] != ball.x || block.y[k] != ball.y || block.z[k] != ball.z || block.R[k] != ball.R)
			return violation("block and ball differ", size_t(index) * W + k);
		if (k >= int(block.count))
		{
			if (ball.R != 0 || ball.density != 0) return violation("padding is not empty", size_t(index) * W + k);
			continue;
		}
		if (!(ball.R > 0) || !(ball.density > 0)) return violation("ball without mass", size_t(index) * W + k);
		if (!inside(own, ball)) return violation("block bound does not contain its balls", index);
		for (const Bound& bound : path)
			if (!inside(bound, ball)) return violation("node bound does not contain ball", size_t(index) * W + k);
	}
	return {};
}
}  // namespace

uint32_t BallTree::ballCount() const
{
	uint32_t count = 0;
	for (const BallBlock& block : blocks) count += block.count;
	return count;
}

std::string BallTree::validate() const
{
	if (balls.size() != blocks.size() * BallBlock::kWidth) return "ball count is not sixteen for each block";
	if (nodes.empty()) return blocks.empty() ? std::string() : "blocks without nodes";
	std::vector<char> nodeSeen(nodes.size()), blockSeen(blocks.size());
	struct Cursor
	{
		uint32_t node;
		int lane;
	};
	std::vector<Cursor> stack{{0, 0}};
	std::vector<Bound> path;
	nodeSeen[0] = 1;
	while (!stack.empty())
	{
		Cursor& top = stack.back();
		if (top.lane == BallNode::kWidth)
		{
			stack.pop_back();
			if (!path.empty()) path.pop_back();
			continue;
		}
		const BallNode& node = nodes[top.node];
		const int k = top.lane++;
		const Bound bound{node.x[k], node.y[k], node.z[k], node.r[k]};
		if (!isFinite(Vec3{bound.x, bound.y, bound.z}) || !std::isfinite(bound.r) || bound.r < 0)
			return violation("node bound not finite", top.node);
		const uint32_t child = node.child[k];
		if (child == BallNode::kNoChild)
		{
			if (bound.r != 0) return violation("empty lane with a radius", top.node);
			continue;
		}
		const uint32_t index = child & ~BallNode::kLeafBit;
		const bool leaf = (child & BallNode::kLeafBit) != 0;
		if (index >= (leaf ? blocks.size() : nodes.size())) return violation("child out of range", top.node);
		char& seen = leaf ? blockSeen[index] : nodeSeen[index];
		if (seen) return violation(leaf ? "block reached twice" : "node reached twice", index);
		seen = 1;
		path.push_back(bound);
		if (leaf)
		{
			std::string problem = checkBlock(*this, index, path);
			if (!problem.empty()) return problem;
			path.pop_back();
			continue;
		}
		if (stack.size() >= size_t(kMaxTreeDepth)) return "tree too deep";
		stack.push_back({index, 0});
	}
	for (size_t i = 0; i < nodes.size(); ++i)
		if (!nodeSeen[i]) return violation("node never reached", i);
	for (size_t i = 0; i < blocks.size(); ++i)
		if (!blockSeen[i]) return violation("block never reached", i);
	return {};
}

BallTree buildBallTree(const std::vector<MomentBall>& balls)
{
	if (balls.empty()) return {};
	return Builder(balls).collapse();
}
}  // namespace ist
