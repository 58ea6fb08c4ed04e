// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Kernels/QueryMemory.h"
#include "BulletISTCollision/Core/Lens.h"

#include <algorithm>

namespace ist
{
namespace
{
const BallTree& treeOf(const InnerSphereTree& body, Model model)
{
	return model == Model::Law ? body.law : model == Model::Cell ? body.cells : body.inner;
}

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

/// Ellipsoids of A that reach below the plane; the same pair list and sums as with a tree. Source: cap of an ellipsoid, exact.
class CapFinder
{
public:
	CapFinder(const BallTree& A, const Vec3& normal, double offset, QueryWorkspace::Implementation& work,
			  const QueryOptions& options, Accumulator& sums, OverlapResult& result)
		: m_A(A), m_normal(normal), m_offset(offset), m_work(work), m_options(options), m_sums(sums), m_result(result)
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
		const MomentEllipsoid& a = m_A.balls[index];
		Lens cap;
		if (!capOf(a, m_normal, dot(m_normal, a.center()) - m_offset, cap)) return;
		const OverlapPair pair{index, 0, float(cap.volume), float(cap.area), cap.centroid, m_normal};
		PairTerm term;
		term.dd = a.density;
		term.smallVolume = ballVolume(a.R);
		term.normalA = a.normal();
		term.normalB = m_normal;
		term.depthA = a.depth - dot(term.normalA, pair.centroid - a.center());
		term.depthB = m_offset - dot(m_normal, pair.centroid);
		m_sums.add(pair, term, m_options.stiffness);
		if (!m_options.sortPairs) return;
		if (m_pairs < m_work.capacity.pairs)
			m_work.pairs[m_pairs++] = pair;
		else
			m_result.pairListComplete = false;
	}

	const BallTree& m_A;
	const Vec3 m_normal;
	const double m_offset;
	QueryWorkspace::Implementation& m_work;
	const QueryOptions& m_options;
	Accumulator& m_sums;
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
	if (options.level < -1 || options.level > 0 || options.maxPairs >= 0) return result.status = QueryStatus::Unsupported, result;
	const BallTree& tree = treeOf(A, options.model);
	if (tree.empty()) return result.status = QueryStatus::EmptyTree, result;

	QueryWorkspace::Implementation& work = workspace.implementation();
	Accumulator sums;
	sums.clear();
	if (options.sortPairs) work.reservePairs();
	// The same plane with a normal of exactly unit length.
	const double length = norm(normal);
	const Vec3 unit = normal / length;
	const int count =
		CapFinder(tree, unit, offset / length - dot(unit, A.origin), work, options, sums, result).run();
	if (options.sortPairs)
	{
		std::sort(work.pairs.begin(), work.pairs.begin() + count,
				  [](const OverlapPair& p, const OverlapPair& q) { return p.ballA < q.ballA; });
		result.pairs = work.pairs.data();
		result.pairCount = count;
	}
	// All pairs share the half-space and its direction: one patch.
	sums.finish();
	result.total = work.patches[0] = sums.sums;
	result.patches = work.patches.data();
	result.patchCount = result.total.pairs > 0 ? 1 : 0;
	return result;
}
}  // namespace ist
