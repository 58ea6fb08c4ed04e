// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tree/BallTree.h"

#include "BulletISTCollision/Core/Tree/TreeCheck.h"
#include "BulletISTCollision/Core/Tree/TreeLimits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace ist
{
namespace
{
[[maybe_unused]] constexpr int kFewestToShare = 4096;  // smallest number of balls that threads share
constexpr size_t kFewestToThin = 1024;                 // smallest number of balls that are thinned out before their bounding sphere is
													   // computed
constexpr int kDirections = 8;                         // number along each side of each face of a cube

/// Binary tree over ranges of the final ball order. A node whose children are -1 is one block.
struct BinaryNode
{
	int begin = 0, end = 0;
	int left = -1, right = -1;
	BoundingBall bound{};
};

/// A ball in the compact form that the build reads many times.
struct BuildBall
{
	float x, y, z, R;
	Vec3 center() const { return {x, y, z}; }
};

class Builder
{
public:
	/// Ball index of an empty slot.
	static constexpr uint32_t kPadding = 0xffffffffu;

	Builder(const std::vector<MomentEllipsoid>& balls, [[maybe_unused]] int threads)
		: m_side(balls.size()),
		  m_buffer(balls.size()),
		  m_cost(balls.size() / kBlockWidth + 2)
	{
		m_balls.reserve(balls.size());
		for (const MomentEllipsoid& b : balls) m_balls.push_back({b.x, b.y, b.z, b.R});
		// Every leaf except the last is a full block.
		m_binary.resize(2 * blocksOf(int(balls.size())) - 1);
#pragma omp parallel num_threads(threads) if (balls.size() >= kFewestToShare)
#pragma omp single
		{
#pragma omp taskloop grainsize(1)
			for (int axis = 0; axis < 3; ++axis) sortAlong(axis);
			split(0, 0, int(balls.size()));
		}
	}

	void collapse()
	{
		m_nodes.emplace_back();
		fillNode(0, 0);
	}
	std::vector<BallNode>& nodes() { return m_nodes; }
	/// The ball index of each slot.
	std::vector<uint32_t>& slots() { return m_slots; }

private:
	static int blocksOf(int count) { return (count + kBlockWidth - 1) / kBlockWidth; }
	void sortAlong(int axis);
	void split(int index, int begin, int end);
	bool bestSplit(int begin, int end, int& bestAxis, int& bestSplit);
	void partition(int begin, int end, int axis, int middle);
	BoundingBall bound(int begin, int end) const;
	void fillNode(uint32_t node, int binary);
	uint32_t makeBlock(const BinaryNode& leaf);

	struct Extent
	{
		Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
		void add(const BuildBall& b)
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

	std::vector<BuildBall> m_balls;
	std::vector<int> m_order[3];
	// Parts of the tree that are built in parallel use disjoint parts of these arrays.
	std::vector<char> m_side;
	std::vector<int> m_buffer;
	std::vector<double> m_cost;
	std::vector<BinaryNode> m_binary;  ///< in the order: a node, the nodes left below it, the nodes right below it
	std::vector<BallNode> m_nodes;
	std::vector<uint32_t> m_slots;
};

void Builder::sortAlong(int axis)
{
	// Sorts floats by the order of their bits. The index breaks ties, so that the tree does not depend on the sort.
	std::vector<uint64_t> keys(m_balls.size());
	for (size_t i = 0; i < keys.size(); ++i)
	{
		const BuildBall& b = m_balls[i];
		const float value = (axis == 0 ? b.x : axis == 1 ? b.y : b.z) + 0.0f;  // no negative zero
		uint32_t bits;
		std::memcpy(&bits, &value, sizeof bits);
		bits ^= bits >> 31 ? 0xffffffffu : 0x80000000u;
		keys[i] = uint64_t(bits) << 32 | i;
	}
	std::sort(keys.begin(), keys.end());
	m_order[axis].resize(keys.size());
	for (size_t i = 0; i < keys.size(); ++i) m_order[axis][i] = int(keys[i] & 0xffffffffu);
}

bool Builder::bestSplit(int begin, int end, int& bestAxis, int& bestSplit)
{
	constexpr int W = kBlockWidth;
	const int count = end - begin, blocks = blocksOf(count);
	if (blocks < 2) return false;
	// Each side gets at least a quarter, which bounds the depth for any set of balls.
	const int first = std::max(1, blocks / 4), last = std::min(blocks - 1, blocks - blocks / 4);
	double best = std::numeric_limits<double>::infinity();
	double* costs = m_cost.data() + begin / W;
	bestAxis = 0;
	bestSplit = begin + first * W;
	for (int axis = 0; axis < 3; ++axis)
	{
		const int* order = m_order[axis].data() + begin;
		Extent right;
		for (int i = count - 1; i >= first * W; --i)
		{
			right.add(m_balls[order[i]]);
			if (i % W == 0) costs[i / W] = right.cost(count - i);
		}
		Extent left;
		for (int i = 0; i < last * W; ++i)
		{
			left.add(m_balls[order[i]]);
			const int k = (i + 1) / W;
			if ((i + 1) % W != 0 || k < first) continue;
			const double cost = left.cost(i + 1) + costs[k];
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

/// Keeps the outermost ball in each direction from the middle, or all if they are few.
void keepOutermost(std::vector<BuildBall>& balls, const Vec3& middle)
{
	if (balls.size() <= kFewestToThin) return;
	constexpr int cells = 6 * kDirections * kDirections;
	std::array<double, cells> reach;
	std::array<uint32_t, cells> outermost;
	reach.fill(-1);
	for (uint32_t i = 0; i < balls.size(); ++i)
	{
		const Vec3 d = balls[i].center() - middle;
		const int axis = std::fabs(d.x) >= std::fabs(d.y) && std::fabs(d.x) >= std::fabs(d.z) ? 0
			: std::fabs(d.y) >= std::fabs(d.z)                                                ? 1
																							  : 2;
		const double scale = d[axis] != 0 ? 0.5 * kDirections / std::fabs(d[axis]) : 0;
		const auto bin = [&](double v) { return std::min(kDirections - 1, int(v * scale + 0.5 * kDirections)); };
		const int cell = ((2 * axis + (d[axis] < 0)) * kDirections + bin(d[(axis + 1) % 3])) * kDirections + bin(d[(axis + 2) % 3]);
		const double far = norm(d) + balls[i].R;
		if (far <= reach[size_t(cell)]) continue;
		reach[size_t(cell)] = far;
		outermost[size_t(cell)] = i;
	}
	std::vector<BuildBall> kept;
	for (size_t k = 0; k < size_t(cells); ++k)
		if (reach[k] >= 0) kept.push_back(balls[outermost[k]]);
	balls.swap(kept);
}

/// Badoiu and Clarkson's iteration: steps of decreasing length towards the farthest ball.
Vec3 centerOf(const std::vector<BuildBall>& balls, Vec3 c)
{
	Vec3 bestCenter = c;
	double best = std::numeric_limits<double>::infinity();
	size_t farthest = 0;
	for (int step = 0; step < 48; ++step)
	{
		// The search begins with the ball that was farthest before. Then most of the others need no square root.
		double reach = distance(balls[farthest].center(), c) + balls[farthest].R;
		for (size_t i = 0; i < balls.size(); ++i)
		{
			const double rest = reach - balls[i].R, d2 = squaredNorm(balls[i].center() - c);
			if (rest >= 0 && d2 <= rest * rest) continue;
			reach = std::sqrt(d2) + balls[i].R;
			farthest = i;
		}
		if (reach < best)
		{
			best = reach;
			bestCenter = c;
		}
		c += (balls[farthest].center() - c) * (1.0 / (step + 4));
	}
	return bestCenter;
}

BoundingBall Builder::bound(int begin, int end) const
{
	const int* order = m_order[0].data();
	Extent box;
	std::vector<BuildBall> balls;
	balls.reserve(size_t(end - begin));
	for (int i = begin; i < end; ++i)
	{
		balls.push_back(m_balls[order[i]]);
		box.add(balls.back());
	}
	const Vec3 middle = (box.low + box.high) / 2;
	keepOutermost(balls, middle);
	const Vec3 center = centerOf(balls, middle);
	BoundingBall result{float(center.x), float(center.y), float(center.z), 0};
	const Vec3 rounded{result.x, result.y, result.z};
	double reach = 0;
	for (int i = begin; i < end; ++i) reach = std::max(reach, distance(m_balls[order[i]].center(), rounded) + m_balls[order[i]].R);
	result.r = std::nextafter(float(reach * (1 + 1e-12)), std::numeric_limits<float>::infinity());
	return result;
}

void Builder::split(int index, int begin, int end)
{
	m_binary[index] = {begin, end, -1, -1, bound(begin, end)};
	int axis, middle;
	if (!bestSplit(begin, end, axis, middle)) return;
	partition(begin, end, axis, middle);
	const int left = index + 1, right = index + 2 * blocksOf(middle - begin);
	m_binary[index].left = left;
	m_binary[index].right = right;
#pragma omp task if (middle - begin >= kFewestToShare)
	split(left, begin, middle);
	split(right, middle, end);
}

uint32_t Builder::makeBlock(const BinaryNode& leaf)
{
	for (int k = leaf.begin; k < leaf.begin + kBlockWidth; ++k)
		m_slots.push_back(k < leaf.end ? uint32_t(m_order[0][size_t(k)]) : kPadding);
	return uint32_t(m_slots.size() / kBlockWidth - 1);
}

void Builder::fillNode(uint32_t node, int binary)
{
	int children[BallNode::kWidth] = {binary};
	int count = 1;
	while (count < BallNode::kWidth)
	{
		int widest = -1;
		for (int k = 0; k < count; ++k)
			if (m_binary[children[k]].left >= 0 && (widest < 0 || m_binary[children[k]].bound.r > m_binary[children[widest]].bound.r))
				widest = k;
		if (widest < 0) break;
		const BinaryNode& open = m_binary[children[widest]];
		children[count++] = open.right;
		children[widest] = open.left;
	}
	for (int k = 0; k < BallNode::kWidth; ++k)
	{
		BoundingBall b{kFarAway, kFarAway, kFarAway, 0};
		uint32_t child = BallNode::kNoChild;
		if (k < count)
		{
			const BinaryNode& source = m_binary[children[k]];
			b = source.bound;
			if (source.left < 0) child = makeBlock(source) | BallNode::kLeafBit;
			else
			{
				child = uint32_t(m_nodes.size());
				m_nodes.emplace_back();
				fillNode(child, children[k]);
			}
		}
		BallNode& target = m_nodes[node];
		target.x[k] = b.x;
		target.y[k] = b.y;
		target.z[k] = b.z;
		target.r[k] = b.r;
		target.child[k] = child;
	}
}

bool finite(const MomentEllipsoid& b)
{
	return isFinite(b.center()) && isFinite(b.normal()) && std::isfinite(b.R) && std::isfinite(b.density) && std::isfinite(b.depth) &&
		std::isfinite(b.shape().trace()) && std::isfinite(b.xy + b.xz + b.yz);
}

bool inside(const BoundingBall& bound, const MomentEllipsoid& ball)
{
	return distance({bound.x, bound.y, bound.z}, ball.center()) + ball.R <= double(bound.r) * (1 + 1e-12);
}

std::string violation(const char* what, size_t index) { return std::string(what) + " (index " + std::to_string(index) + ")"; }

std::string checkBlock(const BallTree& tree, uint32_t index, const std::vector<BoundingBall>& path)
{
	constexpr int W = kBlockWidth;
	const int count = int(tree.ballCount(index));
	if (count < 1) return violation("block without balls", index);
	for (int k = 0; k < W; ++k)
	{
		const size_t slot = size_t(index) * W + k;
		const MomentEllipsoid ball = tree.ball(slot);
		if (!finite(ball)) return violation("ball not finite", slot);
		if (!isFinite(tree.gradient(slot).matrix())) return violation("gradient not finite", slot);
		if (k >= count)
		{
			if (ball.R != 0 || ball.density != 0 || !(ball.x >= kFarPadding)) return violation("padding is not empty and far away", slot);
			continue;
		}
		if (!(ball.R > 0) || !(ball.density > 0)) return violation("ball without mass", slot);
		if (!ball.isSolid()) return violation("ellipsoid flat or larger than its bounding ball", slot);
		if (!isOfABody(ball.density, ball.depth)) return violation("density or depth of no body", slot);
		for (const BoundingBall& bound : path)
			if (!inside(bound, ball)) return violation("node bound does not contain ball", slot);
	}
	return {};
}
}  // namespace

uint32_t BallTree::ballCount() const
{
	return uint32_t(std::count_if(balls.begin(), balls.end(), [](const Sphere& b) { return b.r > 0; }));
}

uint32_t BallTree::ballCount(size_t block) const
{
	const Sphere* first = balls.data() + block * kBlockWidth;
	return uint32_t(std::count_if(first, first + kBlockWidth, [](const Sphere& b) { return b.r > 0; }));
}

size_t BallTree::memory() const
{
	return nodes.size() * sizeof(BallNode) + balls.size() * sizeof(Sphere) + ellipsoids.size() * sizeof(StoredEllipsoid) +
		sphereIndex.size() * sizeof(uint32_t) + gradients.size() * sizeof(NormalGradient);
}

MomentEllipsoid BallTree::packedBall(size_t slot) const
{
	MomentEllipsoid ball = ballOf(balls[slot], sphereIndex[slot]);
	if (!(ball.R > 0)) ball.density = 0;
	return ball;
}

std::vector<MomentEllipsoid> BallTree::slots() const
{
	std::vector<MomentEllipsoid> all;
	all.reserve(slotCount());
	for (size_t slot = 0; slot < slotCount(); ++slot) all.push_back(ball(slot));
	return all;
}

std::string BallTree::validate() const
{
	if (!hasWholeBlocks(*this)) return "ball count is not sixteen for each block";
	if (!gradients.empty() && gradients.size() != ellipsoids.size()) return "not one gradient for each ball";
	if (nodes.empty()) return balls.empty() ? std::string() : "blocks without nodes";
	if (balls.empty()) return "nodes without blocks";
	std::vector<char> nodeSeen(nodes.size()), blockSeen(blockCount());
	struct Cursor
	{
		uint32_t node;
		int lane;
	};
	std::vector<Cursor> stack{{0, 0}};
	std::vector<BoundingBall> path;
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
		const BoundingBall bound{node.x[k], node.y[k], node.z[k], node.r[k]};
		if (!isFinite(Vec3{bound.x, bound.y, bound.z}) || !std::isfinite(bound.r) || bound.r < 0)
			return violation("node bound not finite", top.node);
		const uint32_t child = node.child[k];
		if (child == BallNode::kNoChild)
		{
			if (bound.r != 0) return violation("empty lane with a radius", top.node);
			continue;
		}
		if (!(std::fabs(bound.x) + std::fabs(bound.y) + std::fabs(bound.z) + bound.r < kFarthestBound))
			return violation("node bound comes near to the padding", top.node);
		if (!(std::fabs(bound.x) + std::fabs(bound.y) + std::fabs(bound.z) + bound.r < kMostReach))
			return violation("node bound of a body larger than 10,000 km, whose moments would overflow", top.node);
		const uint32_t index = child & ~BallNode::kLeafBit;
		const bool leaf = (child & BallNode::kLeafBit) != 0;
		if (index >= (leaf ? blockCount() : nodes.size())) return violation("child out of range", top.node);
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
	for (size_t i = 0; i < blockCount(); ++i)
		if (!blockSeen[i]) return violation("block never reached", i);
	return {};
}

namespace
{
/// `of(index)` for the balls in the order of the slots; `padding` for empty slots.
template <class T, class Of> std::vector<T> inSlots(const std::vector<uint32_t>& slots, const T& padding, const Of& of)
{
	std::vector<T> all;
	all.reserve(slots.size());
	for (const uint32_t index : slots) all.push_back(index == Builder::kPadding ? padding : of(index));
	return all;
}

/// The tree's nodes and balls, without ellipsoids.
BallTree boundingTree(const std::vector<MomentEllipsoid>& balls, int threads, std::vector<uint32_t>& slots)
{
	if (balls.empty()) return {};
	Builder builder(balls, threads);
	builder.collapse();
	slots = std::move(builder.slots());
	const Sphere padding{kFarAway, kFarAway, kFarAway, 0};
	const auto bound = [&](uint32_t i) { return Sphere{balls[i].x, balls[i].y, balls[i].z, balls[i].R}; };
	return {std::move(builder.nodes()), inSlots(slots, padding, bound), {}, {}, {}};
}
}  // namespace

BallTree buildBallTree(const std::vector<MomentEllipsoid>& balls, int threads) { return buildBallTree(balls, {}, threads); }

BallTree buildBallTree(const std::vector<MomentEllipsoid>& balls, const std::vector<NormalGradient>& gradients, int threads)
{
	std::vector<uint32_t> slots;
	BallTree tree = boundingTree(balls, threads, slots);
	tree.ellipsoids = inSlots(slots, StoredEllipsoid(), [&](uint32_t i) { return StoredEllipsoid(balls[i]); });
	if (!gradients.empty()) tree.gradients = inSlots(slots, NormalGradient(), [&](uint32_t i) { return gradients[i]; });
	return tree;
}

BallTree buildInnerTree(const FrozenArray<Sphere>& spheres, int threads)
{
	std::vector<MomentEllipsoid> balls(spheres.size());
	for (size_t i = 0; i < spheres.size(); ++i) balls[i] = ballOf(spheres[i], static_cast<uint32_t>(i));
	std::vector<uint32_t> slots;
	BallTree tree = boundingTree(balls, threads, slots);
	tree.sphereIndex = inSlots(slots, uint32_t(0), [](uint32_t i) { return i; });
	return tree;
}
}  // namespace ist
