// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/OverlapQuery.h"

#include "BulletISTCollision/Core/ContactPatches.h"
#include "BulletISTCollision/Core/Kernels/FloatVector.h"
#include "BulletISTCollision/Core/Kernels/TreeLimits.h"
#include "BulletISTCollision/Core/Lens.h"

#include <algorithm>
#include <bit>

namespace ist
{
namespace
{
using kernels::touching;

struct Bound
{
	float x, y, z, r;
};

/// Two subtrees that may touch: node index or block index | kLeafBit, and their bounds in A's tree frame.
struct Item
{
	uint32_t a, b;
	Bound boundA, boundB;
};

/// A block of B in A's tree frame: floats for the tests, doubles for the lenses.
struct MovedBlock
{
	float x[BallBlock::kWidth], y[BallBlock::kWidth], z[BallBlock::kWidth];
	Vec3 center[BallBlock::kWidth];
};

struct PairTerm
{
	double dd, smallVolume;
	Vec3 normalA, normalB;
	double depthA, depthB;  ///< at the lens centroid
};

/// Sums of one patch. The stiffness is kept as the plain outer product g_n (g_wA, g_wB)^T until the end.
struct Accumulator
{
	OverlapIntegrals sums;
	double product[6][12];

	void clear()
	{
		sums = {};
		for (auto& row : product) std::fill(std::begin(row), std::end(row), 0.0);
	}
	void add(const OverlapPair& pair, const PairTerm& term, bool stiffness);
	void finish();
};

void Accumulator::add(const OverlapPair& pair, const PairTerm& term, bool stiffness)
{
	const double mass = term.dd * pair.lens, area = term.dd * pair.area;
	const Vec3 &C = pair.centroid, &n = pair.normal, &mA = term.normalA, &mB = term.normalB;
	const Vec3 turnA = cross(C, mA), turnB = cross(C, mB);
	sums.volume += mass;
	sums.firstMoment += C * mass;
	sums.secondMoment[0] += mass * C.x * C.x;
	sums.secondMoment[1] += mass * C.y * C.y;
	sums.secondMoment[2] += mass * C.z * C.z;
	sums.secondMoment[3] += mass * C.x * C.y;
	sums.secondMoment[4] += mass * C.x * C.z;
	sums.secondMoment[5] += mass * C.y * C.z;
	sums.normalA.force += mA * mass;
	sums.normalA.torque += turnA * mass;
	sums.normalB.force += mB * mass;
	sums.normalB.torque += turnB * mass;
	sums.areaVector += n * area;
	sums.depthA += mass * term.depthA;
	sums.depthB += mass * term.depthB;
	const double s = term.dd * std::max(0.0, std::min<double>(pair.lens, term.smallVolume - pair.lens));
	sums.spread += s * s;
	++sums.pairs;
	if (!stiffness || area == 0) return;
	const Vec3 turnN = cross(C, n);
	const double g[6] = {area * n.x, area * n.y, area * n.z, area * turnN.x, area * turnN.y, area * turnN.z};
	const double w[12] = {-mA.x, -mA.y, -mA.z, -turnA.x, -turnA.y, -turnA.z, mB.x, mB.y, mB.z, turnB.x, turnB.y, turnB.z};
	for (int i = 0; i < 6; ++i)
		for (int j = 0; j < 12; ++j) product[i][j] += g[i] * w[j];
}

void Accumulator::finish()
{
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j)
		{
			sums.stiffnessA(i, j) = 0.5 * (product[i][j] + product[j][i]);
			sums.stiffnessB(i, j) = 0.5 * (product[i][j + 6] + product[j][i + 6]);
		}
}

Bound rootBound(const BallNode& root)
{
	Vec3 center;
	int count = 0;
	for (int k = 0; k < BallNode::kWidth; ++k)
	{
		if (root.child[k] == BallNode::kNoChild) continue;
		center += {root.x[k], root.y[k], root.z[k]};
		++count;
	}
	if (count > 0) center = center / count;
	double reach = 0;
	for (int k = 0; k < BallNode::kWidth; ++k)
		if (root.child[k] != BallNode::kNoChild)
			reach = std::max(reach, distance(center, {root.x[k], root.y[k], root.z[k]}) + root.r[k]);
	return {float(center.x), float(center.y), float(center.z), float(reach * (1 + 1e-6) + 1e-6 * norm(center))};
}

const BallTree& treeOf(const InnerSphereTree& body, Model model)
{
	return model == Model::Law ? body.law : model == Model::Cell ? body.cells : body.inner;
}

Pose treeToTree(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB)
{
	return {X_AB.rotation, X_AB.rotation * B.origin + (X_AB.translation - A.origin)};
}

/// Bound on the relative stretch of lengths by a matrix that is a rotation only within a tolerance.
double stretch(const Mat3& R)
{
	const Mat3 e = R * transpose(R);
	double sum = 0;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) sum += std::fabs(e.m[i][j] - (i == j ? 1 : 0));
	return 1 + sum;
}
}  // namespace

const char* toString(QueryStatus status)
{
	switch (status)
	{
		case QueryStatus::Ok: return "ok";
		case QueryStatus::InvalidPose: return "invalid pose";
		case QueryStatus::EmptyTree: return "empty tree";
		case QueryStatus::Unsupported: return "unsupported";
	}
	return "unknown";
}

void OverlapIntegrals::add(const OverlapIntegrals& o)
{
	volume += o.volume;
	firstMoment += o.firstMoment;
	for (int i = 0; i < 6; ++i) secondMoment[i] += o.secondMoment[i];
	normalA = normalA + o.normalA;
	normalB = normalB + o.normalB;
	areaVector += o.areaVector;
	for (int i = 0; i < 21; ++i)
	{
		stiffnessA.m[i] += o.stiffnessA.m[i];
		stiffnessB.m[i] += o.stiffnessB.m[i];
	}
	depthA += o.depthA;
	depthB += o.depthB;
	spread += o.spread;
	pairs += o.pairs;
}

struct QueryWorkspace::Implementation
{
	QueryCapacity capacity;
	std::vector<Item> stack;
	std::vector<OverlapPair> pairs;
	std::vector<MovedBlock> moved;
	std::vector<uint32_t> movedEpoch;
	uint32_t epoch = 0;
	PatchGrouper grouper;
	std::vector<Accumulator> accumulators;  ///< one for each patch
	std::vector<OverlapIntegrals> patches;

	/// Grows what depends on the size of the trees. Allocates on the first query with a larger tree, never after.
	void reserveFor(const BallTree& A, const BallTree& B)
	{
		if (moved.size() < B.blocks.size())
		{
			moved.resize(B.blocks.size());
			movedEpoch.resize(B.blocks.size(), 0);
		}
		grouper.reserve(size_t(capacity.pairs), A.balls.size() + B.balls.size());
		if (++epoch == 0)
		{
			std::fill(movedEpoch.begin(), movedEpoch.end(), 0u);
			epoch = 1;
		}
	}
};

QueryWorkspace::QueryWorkspace(const QueryCapacity& capacity) : m_impl(std::make_unique<Implementation>())
{
	m_impl->capacity = capacity;
	m_impl->capacity.pairs = std::max(1, capacity.pairs);
	m_impl->capacity.patches = std::clamp(capacity.patches, 1, 1024);
	m_impl->capacity.listEntries = std::max(kPairStackSize, capacity.listEntries);
	m_impl->stack.resize(size_t(m_impl->capacity.listEntries));
	m_impl->pairs.resize(size_t(m_impl->capacity.pairs));
	m_impl->accumulators.resize(size_t(m_impl->capacity.patches));
	m_impl->patches.resize(size_t(m_impl->capacity.patches));
	m_impl->grouper.reserve(size_t(m_impl->capacity.pairs), 0);
}
QueryWorkspace::~QueryWorkspace() = default;
QueryWorkspace::QueryWorkspace(QueryWorkspace&&) noexcept = default;
QueryWorkspace& QueryWorkspace::operator=(QueryWorkspace&&) noexcept = default;
const QueryCapacity& QueryWorkspace::capacity() const { return m_impl->capacity; }

namespace
{
/// One query of two trees. Depth first, so that the stack is bounded by the depth of the trees.
class PairFinder
{
public:
	PairFinder(const BallTree& A, const BallTree& B, const Pose& X, QueryWorkspace::Implementation& work, Accumulator& beyond,
			   bool stiffness, OverlapResult& result)
		: m_A(A), m_B(B), m_X(X), m_work(work), m_beyond(beyond), m_stiffness(stiffness), m_result(result)
	{
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j) m_R[i][j] = float(X.rotation.m[i][j]);
		m_t[0] = float(X.translation.x);
		m_t[1] = float(X.translation.y);
		m_t[2] = float(X.translation.z);
		m_stretch = float(stretch(X.rotation));
	}

	/// Intersecting pairs go to the workspace's list, those that do not fit into `beyond`. Returns the length of the list.
	int run();

private:
	Bound move(const Bound& b) const
	{
		return {m_R[0][0] * b.x + m_R[0][1] * b.y + m_R[0][2] * b.z + m_t[0],
				m_R[1][0] * b.x + m_R[1][1] * b.y + m_R[1][2] * b.z + m_t[1],
				m_R[2][0] * b.x + m_R[2][1] * b.y + m_R[2][2] * b.z + m_t[2], b.r * m_stretch};
	}
	void openA(const Item& item);
	void openB(const Item& item);
	const MovedBlock& movedBlock(uint32_t index);
	void blockPair(const Item& item);
	void exactTest(uint32_t ballA, uint32_t ballB, const Vec3& centerB);

	const BallTree& m_A;
	const BallTree& m_B;
	const Pose& m_X;
	QueryWorkspace::Implementation& m_work;
	Accumulator& m_beyond;
	bool m_stiffness;
	OverlapResult& m_result;
	float m_R[3][3], m_t[3];
	float m_stretch = 1;
	float m_slack = 0;  ///< covers the rounding of float positions: the tests may only err towards touching
	int m_top = 0;
	int m_pairs = 0;
};

int PairFinder::run()
{
	const Bound a = rootBound(m_A.nodes[0]), own = rootBound(m_B.nodes[0]);
	const Vec3 centerA{a.x, a.y, a.z}, centerB = m_X * Vec3{own.x, own.y, own.z};
	const double reachB = own.r * double(m_stretch);
	// In double: far translations would spoil the floats below.
	if (distance(centerA, centerB) > (a.r + reachB) * (1 + 1e-6)) return 0;
	const double scale =
		norm(centerA) + a.r + norm(centerB) + reachB + norm(Vec3{own.x, own.y, own.z}) + norm(m_X.translation);
	m_slack = float(1e-6 * scale);
	Bound b = move(own);
	b.r += m_slack;
	m_work.stack[0] = {0, 0, a, b};
	m_top = 1;
	while (m_top > 0)
	{
		const Item item = m_work.stack[--m_top];
		const bool leafA = item.a & BallNode::kLeafBit, leafB = item.b & BallNode::kLeafBit;
		if (leafA && leafB)
			blockPair(item);
		else if (leafB || (!leafA && item.boundA.r >= item.boundB.r))
			openA(item);
		else
			openB(item);
	}
	return m_pairs;
}

void PairFinder::openA(const Item& item)
{
	const BallNode& node = m_A.nodes[item.a];
	const Bound& b = item.boundB;
	++m_result.nodeVisits;
	uint32_t hits = touching<BallNode::kWidth>(node.x, node.y, node.z, node.r, b.x, b.y, b.z, b.r + m_slack);
	for (; hits; hits &= hits - 1)
	{
		const int k = std::countr_zero(hits);
		if (node.child[k] == BallNode::kNoChild) continue;
		m_work.stack[m_top++] = {node.child[k], item.b, {node.x[k], node.y[k], node.z[k], node.r[k]}, b};
	}
}

void PairFinder::openB(const Item& item)
{
	using V = kernels::FloatVector<BallNode::kWidth>;
	constexpr int W = BallNode::kWidth;
	const BallNode& node = m_B.nodes[item.b];
	const Bound& a = item.boundA;
	++m_result.nodeVisits;
	const V x = V::load(node.x), y = V::load(node.y), z = V::load(node.z);
	float moved[3][W], r[W];
	for (int i = 0; i < 3; ++i)
		(V::all(m_R[i][0]) * x + V::all(m_R[i][1]) * y + V::all(m_R[i][2]) * z + V::all(m_t[i])).store(moved[i]);
	(V::load(node.r) * V::all(m_stretch)).store(r);
	uint32_t hits = touching<W>(moved[0], moved[1], moved[2], r, a.x, a.y, a.z, a.r + m_slack);
	for (; hits; hits &= hits - 1)
	{
		const int k = std::countr_zero(hits);
		if (node.child[k] == BallNode::kNoChild) continue;
		m_work.stack[m_top++] = {item.a, node.child[k], a, {moved[0][k], moved[1][k], moved[2][k], r[k]}};
	}
}

const MovedBlock& PairFinder::movedBlock(uint32_t index)
{
	MovedBlock& moved = m_work.moved[index];
	if (m_work.movedEpoch[index] == m_work.epoch) return moved;
	m_work.movedEpoch[index] = m_work.epoch;
	const BallBlock& block = m_B.blocks[index];
	for (int k = 0; k < BallBlock::kWidth; ++k)
	{
		const Vec3 c = m_X * Vec3{block.x[k], block.y[k], block.z[k]};
		moved.center[k] = c;
		moved.x[k] = float(c.x);
		moved.y[k] = float(c.y);
		moved.z[k] = float(c.z);
	}
	return moved;
}

void PairFinder::blockPair(const Item& item)
{
	constexpr int W = BallBlock::kWidth;
	const uint32_t indexA = item.a & ~BallNode::kLeafBit, indexB = item.b & ~BallNode::kLeafBit;
	const BallBlock& a = m_A.blocks[indexA];
	const BallBlock& b = m_B.blocks[indexB];
	const Bound& bound = item.boundB;
	++m_result.blockPairs;
	// Masks keep padding out: both sides' padding lies at the same far point when the poses coincide.
	const uint32_t realA = (1u << a.count) - 1, realB = (1u << b.count) - 1;
	uint32_t near = realA & touching<W>(a.x, a.y, a.z, a.R, bound.x, bound.y, bound.z, bound.r + m_slack);
	if (!near) return;
	const MovedBlock& moved = movedBlock(indexB);
	m_result.ballTests += int64_t(std::popcount(near)) * b.count;
	for (; near; near &= near - 1)
	{
		const int i = std::countr_zero(near);
		uint32_t hits = realB & touching<W>(moved.x, moved.y, moved.z, b.R, a.x[i], a.y[i], a.z[i], a.R[i] + m_slack);
		for (; hits; hits &= hits - 1)
		{
			const int j = std::countr_zero(hits);
			exactTest(indexA * W + i, indexB * W + j, moved.center[j]);
		}
	}
}

PairTerm termOf(const MomentBall& a, const MomentBall& b, const Vec3& centerB, const Vec3& centroid, const Mat3& R)
{
	PairTerm term;
	term.dd = double(a.density) * b.density;
	term.smallVolume = ballVolume(std::min(a.R, b.R));
	term.normalA = a.normal();
	term.normalB = R * b.normal();
	term.depthA = a.depth - dot(term.normalA, centroid - a.center());
	term.depthB = b.depth - dot(term.normalB, centroid - centerB);
	return term;
}

void PairFinder::exactTest(uint32_t ballA, uint32_t ballB, const Vec3& centerB)
{
	const MomentBall& a = m_A.balls[ballA];
	Lens lens;
	if (!lensOf(a.center(), a.R, centerB, m_B.balls[ballB].R, lens)) return;
	const OverlapPair pair{ballA, ballB, float(lens.volume), float(lens.area), lens.centroid, lens.normal};
	if (m_pairs < m_work.capacity.pairs)
	{
		m_work.pairs[m_pairs++] = pair;
		return;
	}
	m_result.pairListComplete = false;
	m_beyond.add(pair, termOf(a, m_B.balls[ballB], centerB, pair.centroid, m_X.rotation), m_stiffness);
}

void publish(QueryWorkspace::Implementation& work, int patchCount, OverlapResult& result)
{
	for (int p = 0; p < patchCount; ++p)
	{
		work.accumulators[p].finish();
		work.patches[p] = work.accumulators[p].sums;
		result.total.add(work.patches[p]);
	}
	result.patches = work.patches.data();
	result.patchCount = patchCount;
}

void publishPairs(QueryWorkspace::Implementation& work, int count, OverlapResult& result)
{
	std::sort(work.pairs.begin(), work.pairs.begin() + count, [](const OverlapPair& p, const OverlapPair& q) {
		return p.ballA != q.ballA ? p.ballA < q.ballA : p.ballB < q.ballB;
	});
	result.pairs = work.pairs.data();
	result.pairCount = count;
}
}  // namespace

OverlapResult queryOverlap(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, QueryWorkspace& workspace,
						   const QueryOptions& options)
{
	OverlapResult result;
	if (!isRigid(X_AB)) return result.status = QueryStatus::InvalidPose, result;
	if (options.level != -1) return result.status = QueryStatus::Unsupported, result;
	const BallTree &treeA = treeOf(A, options.model), &treeB = treeOf(B, options.model);
	if (treeA.empty() || treeB.empty()) return result.status = QueryStatus::EmptyTree, result;

	QueryWorkspace::Implementation& work = workspace.implementation();
	work.reserveFor(treeA, treeB);
	const Pose X = treeToTree(A, B, X_AB);
	work.accumulators[0].clear();
	const int count = PairFinder(treeA, treeB, X, work, work.accumulators[0], options.stiffness, result).run();
	if (options.sortPairs) publishPairs(work, count, result);

	int patchCount = count > 0 ? 1 : 0;
	const bool grouped = options.patches && result.pairListComplete && work.capacity.patches > 1;
	if (grouped) patchCount = work.grouper.group(work.pairs.data(), count, treeA, treeB, X.rotation, work.capacity.patches);
	for (int p = 1; p < patchCount; ++p) work.accumulators[p].clear();
	const uint16_t* patch = work.grouper.patch();
	for (int i = 0; i < count; ++i)
	{
		const OverlapPair& pair = work.pairs[i];
		const Vec3& centerB = work.moved[pair.ballB / BallBlock::kWidth].center[pair.ballB % BallBlock::kWidth];
		const PairTerm term =
			termOf(treeA.balls[pair.ballA], treeB.balls[pair.ballB], centerB, pair.centroid, X.rotation);
		work.accumulators[grouped ? patch[i] : 0].add(pair, term, options.stiffness);
	}
	publish(work, patchCount, result);
	return result;
}

namespace
{
/// Balls of A that reach below the plane; the same pair list and sums as with a tree. Source: spherical cap, exact.
class CapFinder
{
public:
	CapFinder(const BallTree& A, const Vec3& normal, double offset, QueryWorkspace::Implementation& work, bool stiffness,
			  OverlapResult& result)
		: m_A(A), m_normal(normal), m_offset(offset), m_work(work), m_stiffness(stiffness), m_result(result)
	{
	}

	int run()
	{
		uint32_t* stack = m_stack;
		int top = 0;
		stack[top++] = 0;
		while (top > 0)
		{
			const BallNode& node = m_A.nodes[stack[--top]];
			++m_result.nodeVisits;
			for (int k = 0; k < BallNode::kWidth; ++k)
			{
				if (node.child[k] == BallNode::kNoChild) continue;
				if (dot(m_normal, {node.x[k], node.y[k], node.z[k]}) - m_offset >= node.r[k] * (1 + 1e-6)) continue;
				if (node.child[k] & BallNode::kLeafBit)
					block(node.child[k] & ~BallNode::kLeafBit);
				else
					stack[top++] = node.child[k];
			}
		}
		return m_pairs;
	}

private:
	void block(uint32_t index)
	{
		++m_result.blockPairs;
		const uint32_t first = index * BallBlock::kWidth, count = m_A.blocks[index].count;
		m_result.ballTests += count;
		for (uint32_t ball = first; ball < first + count; ++ball) test(ball);
	}

	void test(uint32_t index)
	{
		const MomentBall& a = m_A.balls[index];
		Lens cap;
		if (!capOf(a.center(), a.R, m_normal, dot(m_normal, a.center()) - m_offset, cap)) return;
		const OverlapPair pair{index, 0, float(cap.volume), float(cap.area), cap.centroid, m_normal};
		PairTerm term;
		term.dd = a.density;
		term.smallVolume = ballVolume(a.R);
		term.normalA = a.normal();
		term.normalB = m_normal;
		term.depthA = a.depth - dot(term.normalA, pair.centroid - a.center());
		term.depthB = m_offset - dot(m_normal, pair.centroid);
		m_work.accumulators[0].add(pair, term, m_stiffness);
		if (m_pairs < m_work.capacity.pairs)
			m_work.pairs[m_pairs++] = pair;
		else
			m_result.pairListComplete = false;
	}

	const BallTree& m_A;
	const Vec3 m_normal;
	const double m_offset;
	QueryWorkspace::Implementation& m_work;
	const bool m_stiffness;
	OverlapResult& m_result;
	uint32_t m_stack[kPairStackSize];
	int m_pairs = 0;
};
}  // namespace

OverlapResult queryHalfSpace(const InnerSphereTree& A, const Vec3& normal, double offset, QueryWorkspace& workspace,
							 const QueryOptions& options)
{
	OverlapResult result;
	if (!isFinite(normal) || !std::isfinite(offset) || !(std::fabs(squaredNorm(normal) - 1) <= 1e-4))
		return result.status = QueryStatus::InvalidPose, result;
	if (options.level != -1) return result.status = QueryStatus::Unsupported, result;
	const BallTree& tree = treeOf(A, options.model);
	if (tree.empty()) return result.status = QueryStatus::EmptyTree, result;

	QueryWorkspace::Implementation& work = workspace.implementation();
	work.accumulators[0].clear();
	// The same plane with a normal of exactly unit length.
	const double length = norm(normal);
	const Vec3 unit = normal / length;
	const int count =
		CapFinder(tree, unit, offset / length - dot(unit, A.origin), work, options.stiffness, result).run();
	if (options.sortPairs) publishPairs(work, count, result);
	// All pairs share the half-space and its direction: one patch.
	publish(work, count > 0 ? 1 : 0, result);
	return result;
}
}  // namespace ist
