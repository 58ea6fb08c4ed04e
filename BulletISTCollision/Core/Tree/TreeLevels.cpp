// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tree/TreeLevels.h"

#include "BulletISTCollision/Core/Leaves/CellSplitter.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace ist
{
namespace
{
// With 3, all levels together take two thirds of the memory of the leaves; with 2 they take a third more than the leaves.
constexpr int kMerged = 3;
/// The coarsest level has at least this many balls.
constexpr size_t kFewestBalls = 24;
/// Weight of positions, in units of the cluster's size, relative to normals. From 1.5 to 3, pairs of bunnies hardly differ
/// (bench_levels). Below 1.8, a square plate is first split into its two sides.
constexpr double kPlaceWeight = 1.8;

using Vec6 = std::array<double, 6>;

/// Position in units of the cluster's size, and normal, both relative to the cluster's.
Vec6 coordinates(const MomentEllipsoid& b, const MomentEllipsoid& cluster)
{
	const double scale = cluster.meanRadius() > 0 ? kPlaceWeight / cluster.meanRadius() : 0;
	const Vec3 place = (b.center() - cluster.center()) * scale, normal = b.normal() - cluster.normal();
	return {place.x, place.y, place.z, normal.x, normal.y, normal.z};
}

/// Direction in which the balls spread most: power iteration on their covariance, weighted by mass.
Vec6 principalAxis(const std::vector<MomentEllipsoid>& balls, const uint32_t* order, size_t count, const MomentEllipsoid& cluster)
{
	double covariance[6][6] = {};
	for (size_t k = 0; k < count; ++k)
	{
		const Vec6 v = coordinates(balls[order[k]], cluster);
		const double mass = balls[order[k]].volume();
		for (int i = 0; i < 6; ++i)
			for (int j = 0; j < 6; ++j) covariance[i][j] += mass * v[i] * v[j];
	}
	int widest = 0;
	for (int i = 1; i < 6; ++i)
		if (covariance[i][i] > covariance[widest][widest]) widest = i;
	Vec6 axis{};
	axis[widest] = 1;
	for (int step = 0; step < 16; ++step)
	{
		Vec6 next{};
		double squared = 0;
		for (int i = 0; i < 6; ++i)
		{
			for (int j = 0; j < 6; ++j) next[i] += covariance[i][j] * axis[j];
			squared += next[i] * next[i];
		}
		if (!(squared > 0)) break;
		for (int i = 0; i < 6; ++i) axis[i] = next[i] / std::sqrt(squared);
	}
	return axis;
}

/// A cut through the hierarchy of one body's leaves. A cluster is a range of `m_order`.
class Cut
{
public:
	explicit Cut(const std::vector<MomentEllipsoid>& balls) : m_balls(balls), m_order(balls.size()), m_key(balls.size())
	{
		std::iota(m_order.begin(), m_order.end(), 0u);
		add(0, balls.size());
	}

	/// Splits the cluster with the largest cost until there are `count`.
	void refine(size_t count)
	{
		while (m_clusters.size() < count) split();
	}

	BallTree tree(int threads) const
	{
		std::vector<MomentEllipsoid> balls;
		std::vector<NormalGradient> gradients;
		for (const Cluster& cluster : m_clusters)
		{
			balls.push_back(cluster.ball);
			gradients.emplace_back().setMatrix(
				normalGradient(cluster.ball, m_balls.data(), m_order.data() + cluster.begin, cluster.end - cluster.begin));
		}
		return buildBallTree(balls, gradients, threads);
	}

	/// Calls `found(sphere)` with the largest sphere of each cluster.
	template <class Found> void forEachLeader(const Found& found) const
	{
		const auto sphere = [&](uint32_t ball) { return m_balls[ball].sphere; };
		for (const Cluster& cluster : m_clusters)
		{
			// Spheres are packed largest first, so the largest has the lowest index.
			uint32_t leader = sphere(m_order[cluster.begin]);
			for (size_t k = cluster.begin + 1; k < cluster.end; ++k) leader = std::min(leader, sphere(m_order[k]));
			found(leader);
		}
	}

private:
	struct Cluster
	{
		size_t begin, end;
		MomentEllipsoid ball;
		double cost;
		// The range breaks ties, so that the result does not depend on the heap.
		bool operator<(const Cluster& other) const { return cost != other.cost ? cost < other.cost : begin > other.begin; }
	};

	void add(size_t begin, size_t end);
	void split();

	const std::vector<MomentEllipsoid>& m_balls;
	std::vector<uint32_t> m_order;
	std::vector<double> m_key;        ///< per ball: its position along the axis of the current split
	std::vector<Cluster> m_clusters;  ///< a heap
};

void Cut::add(size_t begin, size_t end)
{
	Cluster cluster{begin, end, merged(m_balls.data(), m_order.data() + begin, end - begin), 0};
	// The same rule splits cells into leaves.
	const MomentEllipsoid& b = cluster.ball;
	if (end - begin > 1) cluster.cost = splitPriority(b.volume(), b.meanRadius(), b.normal());
	m_clusters.push_back(cluster);
	std::push_heap(m_clusters.begin(), m_clusters.end());
}

void Cut::split()
{
	std::pop_heap(m_clusters.begin(), m_clusters.end());
	const Cluster cluster = m_clusters.back();
	m_clusters.pop_back();
	const auto begin = m_order.begin() + ptrdiff_t(cluster.begin), end = m_order.begin() + ptrdiff_t(cluster.end);
	const Vec6 axis = principalAxis(m_balls, &*begin, cluster.end - cluster.begin, cluster.ball);
	for (auto k = begin; k != end; ++k)
	{
		const Vec6 v = coordinates(m_balls[*k], cluster.ball);
		m_key[*k] = std::inner_product(v.begin(), v.end(), axis.begin(), 0.0);
	}
	// The split is at the mean, which is zero. If all balls have the same position, the range is halved.
	auto middle = std::stable_partition(begin, end, [&](uint32_t ball) { return m_key[ball] < 0; });
	if (middle == begin || middle == end) middle = begin + (end - begin) / 2;
	const size_t at = size_t(middle - m_order.begin());
	add(cluster.begin, at);
	add(at, cluster.end);
}

/// The balls without padding.
std::vector<MomentEllipsoid> solidBalls(const BallTree& leaves)
{
	std::vector<MomentEllipsoid> balls;
	for (const MomentEllipsoid& b : leaves.slots())
		if (b.density > 0) balls.push_back(b);
	return balls;
}

/// Number of balls of each coarser level, the finest first.
std::vector<size_t> levelSizes(size_t balls)
{
	std::vector<size_t> sizes;
	for (size_t size = balls / kMerged; size >= kFewestBalls; size /= kMerged) sizes.push_back(size);
	return sizes;
}
}  // namespace

std::vector<BallTree> buildLevels(const BallTree& leaves, int threads)
{
	const std::vector<MomentEllipsoid> balls = solidBalls(leaves);
	const std::vector<size_t> sizes = levelSizes(balls.size());
	std::vector<BallTree> levels(sizes.size());
	if (sizes.empty()) return levels;
	Cut cut(balls);
	for (size_t i = sizes.size(); i-- > 0;)
	{
		cut.refine(sizes[i]);
		levels[i] = cut.tree(threads);
	}
	return levels;
}

std::vector<int> levelsOfSpheres(const BallTree& leaves, size_t spheres)
{
	const std::vector<MomentEllipsoid> balls = solidBalls(leaves);
	const std::vector<size_t> sizes = levelSizes(balls.size());
	std::vector<int> levels(spheres, 0);
	if (sizes.empty()) return levels;
	Cut cut(balls);
	for (size_t i = sizes.size(); i-- > 0;)
	{
		cut.refine(sizes[i]);
		// The leader of a cluster also leads one of the cluster's parts at every finer level.
		cut.forEachLeader([&](uint32_t sphere) { levels[sphere] = std::max(levels[sphere], int(i) + 1); });
	}
	return levels;
}

int levelCount(const InnerSphereTree& A, const InnerSphereTree& B) { return int(A.levels.size() + B.levels.size()); }

LevelPair levelOf(const InnerSphereTree& A, const InnerSphereTree& B, int level)
{
	size_t a = 0, b = 0;
	const auto tree = [](const InnerSphereTree& body, size_t i) -> const BallTree& { return i == 0 ? body.law : body.levels[i - 1]; };
	for (int step = 0; step < level; ++step)
	{
		const bool takeA = b == B.levels.size() || (a < A.levels.size() && tree(A, a).blockCount() >= tree(B, b).blockCount());
		++(takeA ? a : b);
	}
	return {&tree(A, a), &tree(B, b), int(a), int(b)};
}
}  // namespace ist
