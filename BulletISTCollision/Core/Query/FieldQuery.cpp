// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Geometry/Lens.h"
#include "BulletISTCollision/Core/Query/FieldClipper.h"
#include "BulletISTCollision/Core/Query/InnerOverlap.h"
#include "BulletISTCollision/Core/Query/LevelQuery.h"
#include "BulletISTCollision/Core/Query/QueryWorkspaceState.h"

#include <algorithm>

namespace ist
{
namespace
{
/// Sum of translational stiffnesses S that act at points, referred to the origin: the sum of G S G^T with G = (I, [at] x).
struct PointStiffness
{
	Vec3 force[3], mixed[3], torque[3];  // rows of the blocks; `mixed` gives the forces of rotations

	void add(const SymmetricMatrix3& S, const Vec3& at)
	{
		const Vec3 row[3] = {{S.xx, S.xy, S.xz}, {S.xy, S.yy, S.yz}, {S.xz, S.yz, S.zz}};
		const Vec3 turn[3] = {cross(at, row[0]), cross(at, row[1]), cross(at, row[2])};  // columns of [at] x S
		for (int i = 0; i < 3; ++i)
		{
			force[i] += row[i];
			mixed[i] += turn[i];
		}
		torque[0] += cross(at, {turn[0].x, turn[1].x, turn[2].x});
		torque[1] += cross(at, {turn[0].y, turn[1].y, turn[2].y});
		torque[2] += cross(at, {turn[0].z, turn[1].z, turn[2].z});
	}
	void addTo(SymmetricMatrix6& K) const
	{
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j)
			{
				if (j >= i) K(i, j) += force[i][j];
				if (j >= i) K(i + 3, j + 3) += torque[i][j];
				K(i, j + 3) += mixed[i][j];
			}
	}
};

/// Symmetric part of a b^T.
SymmetricMatrix3 symmetricProduct(const Vec3& a, const Vec3& b)
{
	return {a.x * b.x, a.y * b.y, a.z * b.z, 0.5 * (a.x * b.y + a.y * b.x), 0.5 * (a.x * b.z + a.z * b.x), 0.5 * (a.y * b.z + a.z * b.y)};
}

/// Sums of one patch.
struct Accumulator
{
	OverlapIntegrals sums;
	PointStiffness stiffnessA, stiffnessB, damping;

	void add(const FieldTerm& term, const MomentEllipsoid& leaf, const QueryOptions& options);
	void addDamping(const FieldTerm& term, const Vec3& mA);
	OverlapIntegrals finished() const
	{
		OverlapIntegrals result = sums;
		stiffnessA.addTo(result.stiffnessA);
		stiffnessB.addTo(result.stiffnessB);
		damping.addTo(result.damping);
		return result;
	}
};

void Accumulator::addDamping(const FieldTerm& term, const Vec3& mA)
{
	const Vec3 w = sums.dampingWeights.B * term.normal - sums.dampingWeights.A * mA;
	damping.add(SymmetricMatrix3::square(w) * term.volume, term.centroid);
}

void Accumulator::add(const FieldTerm& term, const MomentEllipsoid& leaf, const QueryOptions& options)
{
	const double mass = term.volume;
	const Vec3 &C = term.centroid, mA = leaf.normal(), first = C * mass, nA = mA * mass, nB = term.normal * mass;
	sums.volume += mass;
	sums.firstMoment += first;
	sums.secondMoment[0] += first.x * C.x;
	sums.secondMoment[1] += first.y * C.y;
	sums.secondMoment[2] += first.z * C.z;
	sums.secondMoment[3] += first.x * C.y;
	sums.secondMoment[4] += first.x * C.z;
	sums.secondMoment[5] += first.y * C.z;
	sums.normalA.force += nA;
	sums.normalA.torque += cross(C, nA);
	sums.normalB.force += nB;
	sums.normalB.torque += cross(C, nB);
	sums.areaVector += term.area;
	sums.depthA += mass * (leaf.depth - dot(mA, C - leaf.center()));
	sums.depthB += mass * term.depth;
	sums.dampingWeights = options.damping;
	if (options.damping != DampingWeights()) addDamping(term, mA);
	if (!options.stiffness) return;
	const bool cut = squaredNorm(term.area) > 0, bent = term.bend.trace() > 0;
	if (cut) stiffnessA.add(symmetricProduct(term.area, -mA), C);
	if (cut || bent) stiffnessB.add(symmetricProduct(term.area, term.normal) + term.bend * -1.0, C);
}

/// Query of the leaves of A that reach into a field. Their terms are listed to be grouped. They are summed at once if there is nothing
/// to group or the list is full.
class FieldQuery : FieldSink
{
public:
	FieldQuery(const BallTree& A, const AnalyticField& field, const Pose& X_AF, QueryWorkspace::Implementation& work,
		const QueryOptions& options, OverlapResult& result)
		: m_A(A),
		  m_clipper(field, X_AF, options.stiffness, *this),
		  m_work(work),
		  m_options(options),
		  m_result(result),
		  m_grouped(options.patches && work.capacity.patches > 1 && !m_clipper.isFlat())
	{}

	void run();

private:
	void descend();
	void test(uint32_t index);
	void take(const FieldTerm& term) override;
	void list(const FieldTerm& term);
	void publish();
	void publishPairs();

	const BallTree& m_A;
	FieldClipper m_clipper;
	QueryWorkspace::Implementation& m_work;
	const QueryOptions& m_options;
	OverlapResult& m_result;
	const bool m_grouped;

	Accumulator m_rest;     // sums of the terms that are not listed
	Vec3 m_moment, m_area;  // sums of the current leaf
	double m_volume = 0;    // volume of the current leaf
	int64_t m_leaves = 0;
	int m_pairs = 0;
	uint32_t m_stack[kPairStackSize];
};

void FieldQuery::run()
{
	m_work.reserveTerms(m_A);
	if (m_options.sortPairs) m_work.reservePairs();
	m_result.ballsA = &m_A;
	descend();
	publish();
	if (m_options.sortPairs) publishPairs();
}

void FieldQuery::descend()
{
	int top = 0;
	m_stack[top++] = 0;
	while (top > 0)
	{
		const BallNode& node = m_A.nodes[m_stack[--top]];
		++m_result.nodeVisits;
		for (int k = 0; k < BallNode::kWidth; ++k)
		{
			if (node.child[k] == BallNode::kNoChild || !m_clipper.mayReach({node.x[k], node.y[k], node.z[k]}, node.r[k])) continue;
			if (!(node.child[k] & BallNode::kLeafBit))
			{
				m_stack[top++] = node.child[k];
				continue;
			}
			++m_result.blockPairs;
			const uint32_t block = node.child[k] & ~BallNode::kLeafBit, first = block * kBlockWidth, count = m_A.ballCount(block);
			m_result.ballTests += count;
			for (uint32_t ball = first; ball < first + count; ++ball) test(ball);
		}
	}
}

void FieldQuery::test(uint32_t index)
{
	const MomentEllipsoid leaf = m_A.ball(index);
	m_volume = 0;
	m_moment = m_area = {};
	m_clipper.clip(leaf, index);
	if (!(m_volume > 0)) return;
	++m_leaves;
	if (!m_options.sortPairs) return;
	if (m_pairs >= m_work.capacity.pairs)
	{
		m_result.pairListComplete = false;
		return;
	}
	m_work.pairs[m_pairs++] = {
		index, 0, float(m_volume / leaf.density), float(norm(m_area) / leaf.density), m_moment / m_volume, normalized(m_area)};
}

void FieldQuery::take(const FieldTerm& term)
{
	m_volume += term.volume;
	m_moment += term.centroid * term.volume;
	m_area += term.area;
	if (m_grouped && int(m_work.terms.size()) < m_work.capacity.pairs) return list(term);
	if (m_grouped) m_result.pairListComplete = false;
	m_rest.add(term, m_A.ball(term.ball), m_options);
}

// Terms are grouped by the field's normals alone. They distinguish the faces of a box; on a plane all are equal.
void FieldQuery::list(const FieldTerm& term)
{
	const size_t at = m_work.terms.size();
	m_work.terms.push_back(term);
	using kernels::PairStream, kernels::columnOf;
	const PairStream& s = m_work.stream;
	const Vec3 f = term.normal * term.volume;
	s.a[at] = term.ball;
	s.b[at] = 0;
	for (int i = 0; i < 3; ++i)
	{
		columnOf(s, PairStream::Force + i)[at] = float(f[i]);
		columnOf(s, PairStream::Centroid + i)[at] = float(term.centroid[i]);
	}
	columnOf(s, PairStream::Size)[at] = columnOf(s, PairStream::Rank)[at] = float(norm(f));
}

void FieldQuery::publish()
{
	const int listed = int(m_work.terms.size());
	const bool grouped = listed > 0 && m_result.pairListComplete;
	// The integrals against a field need no kernel, so the query also answers if the wanted instruction set cannot run here.
	const kernels::QueryKernel& kernel = m_work.kernel ? *m_work.kernel : kernels::kPortableKernel;
	const int groups = grouped ? m_work.grouper.group(kernel, m_work.stream, listed, uint32_t(m_A.slotCount()), m_work.capacity.patches)
							   : 1;
	for (int p = 0; p < groups; ++p)
	{
		Accumulator sums = p == 0 ? m_rest : Accumulator();
		for (int i = 0; i < listed; ++i)
			if (groups == 1 || m_work.grouper.patch()[i] == kernels::GroupNumber(p))
				sums.add(m_work.terms[i], m_A.ball(m_work.terms[i].ball), m_options);
		m_work.patches[p] = sums.finished();
	}
	OverlapIntegrals& total = m_result.total;
	for (int p = 0; p < groups; ++p) total.add(m_work.patches[p]);
	total.pairs = m_leaves;
	// A leaf that an edge divides belongs to two patches. Each patch counts the leaves by its share of the volume.
	for (int p = 0; p < groups; ++p)
	{
		const double share = total.volume > 0 ? m_work.patches[p].volume / total.volume : 0;
		m_work.patches[p].pairs = groups == 1 ? m_leaves : int64_t(std::llround(double(m_leaves) * share));
	}
	m_result.patches = m_work.patches.data();
	m_result.patchCount = m_leaves > 0 ? groups : 0;
}

void FieldQuery::publishPairs()
{
	std::sort(
		m_work.pairs.begin(), m_work.pairs.begin() + m_pairs, [](const OverlapPair& p, const OverlapPair& q) { return p.ballA < q.ballA; });
	m_result.pairs = m_work.pairs.data();
	m_result.pairCount = m_pairs;
}

/// Whether A's surface answers, and not its leaves. X: pose of the field's frame in A's tree frame.
bool answersSurface(const InnerSphereTree& A, const AnalyticField& field, const Pose& X, const QueryOptions& options)
{
	return wantSurfaces(options, options.level) && !A.surface.empty() &&
		PlanarBody::canLayOut(field, ballAround(A.surface.surface, inverse(X)));
}

/// Answers with the surfaces of both bodies. Returns false if there are more faces than the workspace holds.
bool querySurfaceInField(const InnerSphereTree& A, const AnalyticField& field, const Pose& X, QueryWorkspace::Implementation& work,
	const QueryOptions& options, OverlapResult& result)
{
	result.ballsA = &A.law;
	++result.nodeVisits;
	if (!work.planar.place(field, ballAround(A.surface.surface, inverse(X)))) return true;
	const QueryLimits limits{-1, work.capacity.patches};
	const Pose X_AB = X * work.planar.X_FB();
	return querySurfaces(A.surface, work.planar.body(), X_AB, work, options, limits, result) == SurfaceAnswer::Good;
}

Pose fieldInTree(const InnerSphereTree& A, const Pose& X_AF) { return {X_AF.rotation, X_AF.translation - A.origin}; }

OverlapResult queryTreeInField(
	const InnerSphereTree& A, const AnalyticField& field, const Pose& X_AF, QueryWorkspace& workspace, const QueryOptions& options)
{
	OverlapResult result;
	if (!isRigid(X_AF) || !field.isValid()) return result.status = QueryStatus::InvalidPose, result;
	if (options.level < -1 || options.level > 0 || options.maxPairs >= 0 || options.otherShare != 0)
		return result.status = QueryStatus::Unsupported, result;
	const BallTree& tree = treeOf(A, options.model);
	if (tree.empty()) return result.status = QueryStatus::EmptyTree, result;
	const Pose X = fieldInTree(A, X_AF);
	// The sums of leaves are right however many there are.
	if (answersSurface(A, field, X, options) && querySurfaceInField(A, field, X, workspace.implementation(), options, result))
		return result;
	result = {};
	FieldQuery(tree, field, X, workspace.implementation(), options, result).run();
	return result;
}
}  // namespace

OverlapResult queryField(
	const InnerSphereTree& A, const AnalyticField& field, const Pose& X_AF, QueryWorkspace& workspace, const QueryOptions& options)
{
	if (wantsInnerOverlap(options) && isRigid(X_AF) && answersSurface(A, field, fieldInTree(A, X_AF), options))
	{
		// Surfaces do not reach beyond the bodies.
		QueryOptions sharp = options;
		sharp.requireInnerOverlap = sharp.gate = false;
		return queryTreeInField(A, field, X_AF, workspace, sharp);
	}
	return answerWithInnerOverlap(
		options, workspace, [&](const QueryOptions& o) { return queryTreeInField(A, field, X_AF, workspace, o); });
}

OverlapResult queryHalfSpace(
	const InnerSphereTree& A, const Vec3& normal, double offset, QueryWorkspace& workspace, const QueryOptions& options)
{
	// This is the same plane with a normal of exactly unit length.
	const double length = HalfSpaceField(normal, offset).isValid() ? norm(normal) : 1;
	return queryField(A, HalfSpaceField(normal / length, offset / length), {}, workspace, options);
}
}  // namespace ist
