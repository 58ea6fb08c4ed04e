// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/TreeQuery.h"

#include "BulletISTCollision/Core/Base/SamePose.h"
#include "BulletISTCollision/Core/Geometry/Lens.h"

#include <algorithm>

namespace ist
{
using namespace kernels;

namespace
{
BoundingBall rootBound(const BallNode& root)
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
		if (root.child[k] != BallNode::kNoChild) reach = std::max(reach, distance(center, {root.x[k], root.y[k], root.z[k]}) + root.r[k]);
	return {float(center.x), float(center.y), float(center.z), float(reach * (1 + 1e-6) + 1e-6 * norm(center))};
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

OverlapIntegrals collect(const double* sums, const DampingWeights& damping)
{
	const auto vector = [&](int i) { return Vec3{sums[i], sums[i + 1], sums[i + 2]}; };
	const auto wrench = [&](int i) { return Wrench{vector(i), vector(i + 3)}; };
	OverlapIntegrals o;
	o.volume = sums[kVolume];
	o.firstMoment = vector(kFirst);
	std::copy_n(sums + kSecond, 6, o.secondMoment);
	o.normalA = wrench(kNormalA);
	o.normalB = wrench(kNormalB);
	o.line = wrench(kLine);
	o.areaVector = vector(kArea);
	o.depthA = sums[kDepthA];
	o.depthB = sums[kDepthB];
	o.pairs = int64_t(sums[kPairs]);
	const auto product = [&](int i, int j) { return sums[kProduct + 12 * i + j]; };
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j)
		{
			o.stiffnessA(i, j) = 0.5 * (product(i, j) + product(j, i));
			o.stiffnessB(i, j) = 0.5 * (product(i, j + 6) + product(j, i + 6));
		}
	const double* blocks = sums + kDamping;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j)
		{
			o.damping(i, j + 3) = blocks[9 + 3 * i + j];
			if (j < i) continue;
			o.damping(i, j) = 0.5 * (blocks[3 * i + j] + blocks[3 * j + i]);
			o.damping(i + 3, j + 3) = 0.5 * (blocks[18 + 3 * i + j] + blocks[18 + 3 * j + i]);
		}
	o.dampingWeights = damping;
	return o;
}

/// Fills the kListSlack entries behind the last one, because kernels read whole vectors. The entries must be valid balls, and those of B
/// must have been transformed.
void pad(uint32_t* a, uint32_t* b, int count)
{
	if (count == 0) return;
	std::fill_n(a + count, kListSlack, a[count - 1]);
	std::fill_n(b + count, kListSlack, b[count - 1]);
}
}  // namespace

TreeQuery::TreeQuery(const BallTree& A, const BallTree& B, const Pose& X, QueryWorkspace::Implementation& work, const QueryOptions& options,
	const QueryLimits& limits, OverlapResult& result, VerletList::Implementation* list)
	: m_A(A),
	  m_B(B),
	  m_X(X),
	  m_work(work),
	  m_options(options),
	  m_limits(limits),
	  m_result(result),
	  m_list(list)
{
	m_terms = options.model == Model::Inner ? kLineTerms : options.stiffness ? kStiffnessTerms : kFieldTerms;
	m_grouped = options.patches && limits.patches > 1 && !options.listMeetingBounds;
	m_bodies.keepMeeting = options.listMeetingBounds;
	if (hasShapes()) m_damping = options.damping;
	m_bodies.weightA = float(m_damping.A);
	m_bodies.weightB = float(m_damping.B);
	m_bodies.ballsA = A.balls.data();
	m_bodies.ballsB = B.balls.data();
	m_bodies.ellipsoidsA = A.ellipsoids.data();
	m_bodies.ellipsoidsB = B.ellipsoids.data();
	m_bodies.gradientsA = A.gradients.data();
	m_bodies.gradientsB = B.gradients.data();
	m_bodies.centersB = work.movedCenters.data();
	m_bodies.movedB = work.movedBalls.data();
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) m_bodies.R[3 * i + j] = X.rotation.m[i][j];
	for (int i = 0; i < 3; ++i) m_bodies.t[i] = X.translation[i];
}

bool TreeQuery::run()
{
	const bool answered = answer();
	if (m_filled) m_list->end(m_result.total.pairs);
	return answered;
}

bool TreeQuery::answer()
{
	m_result.ballsA = &m_A;
	m_result.ballsB = &m_B;
	if (!find()) return true;
	if (m_limits.pairs >= 0 && m_listed > m_limits.pairs) return false;
	if (m_options.sortPairs) publishPairs();
	const int groups = m_grouped && m_result.pairListComplete
		? m_work.grouper.group(*m_work.kernel, m_work.stream, m_listed, uint32_t(m_A.slotCount()), m_limits.patches)
		: 0;
	const bool recorded = m_list && recordPatches(groups);
	if (groups > 1) publishPatches(groups);
	else publishWhole();
	if (recorded) m_list->note(m_result.patches, m_result.patchCount);
	return true;
}

/// Publishes the answer as one patch.
void TreeQuery::publishWhole()
{
	if (m_listed > 0) m_work.kernel->sumGroup(m_bodies, m_work.stream, nullptr, 0, m_listed, m_terms, m_sums);
	m_result.total = m_work.patches[0] = collect(m_sums, m_damping);
	m_result.patches = m_work.patches.data();
	m_result.patchCount = m_result.total.pairs > 0 ? 1 : 0;
}

void TreeQuery::evaluate(uint32_t* a, uint32_t* b, int count, double* sums) const
{
	pad(a, b, count);
	if (count > 0) m_work.kernel->evaluate(m_bodies, a, b, count, m_terms, sums);
}

bool TreeQuery::place()
{
	const BoundingBall a = rootBound(m_A.nodes[0]), own = rootBound(m_B.nodes[0]);
	const Vec3 centerA{a.x, a.y, a.z}, ownCenter{own.x, own.y, own.z}, centerB = m_X * ownCenter;
	m_lengthening = stretch(m_X.rotation);
	const double reachB = own.r * m_lengthening;
	const double scale = norm(centerA) + a.r + norm(centerB) + reachB + norm(ownCenter) + norm(m_X.translation);
	m_bodies.slack = float(1e-6 * scale);
	m_rootA = {a.x, a.y, a.z, a.r};
	m_rootB = {float(centerB.x), float(centerB.y), float(centerB.z), float(reachB)};
	if (m_list) m_reusesList = m_list->covers(m_A, m_B, m_options, {m_X, ownCenter, own.r});
	// This comparison is in double, because floats are too coarse for distant translations.
	return !(distance(centerA, centerB) > (a.r + reachB) * (1 + 1e-6));
}

bool TreeQuery::find()
{
	if (!place()) return false;
	const double margin = m_list && !m_reusesList ? m_list->marginToFill() : 0;
	const Pose around = margin > 0 ? m_list->poseToFill(margin) : m_X;
	const bool isAhead = margin > 0 && !isSame(around, m_X);
	if (isAhead) m_reusesList = fillAround(around, margin);
	PairSearch s = newSearch();
	m_search = &s;
	if (m_reusesList)
	{
		// Without a search the centres of a whole block need not be transformed: most of them would be unused.
		m_bodies.centersB = nullptr;
		if (listHasPatches() && reusePatches()) return false;
		recall();
		return true;
	}
	m_margin = float(margin * (1 + 1e-6));
	s.slack += m_margin;
	if (m_list) m_list->begin(margin, m_X);
	m_filled = m_list != nullptr;
	beginAtRoots(s);
	m_work.kernel->search(s);
	count(s.counts);
	return true;
}

bool TreeQuery::fillAround(const Pose& around, double margin)
{
	OverlapResult nothing;
	TreeQuery there(m_A, m_B, around, m_work, m_options, m_limits, nothing);
	// If the bounds of the bodies are apart at that pose, filling the list is not worth the cost.
	if (!there.place()) return false;
	there.m_list = m_list;
	there.m_margin = float(margin * (1 + 1e-6));
	there.m_onlyFills = true;
	m_list->begin(margin, around);
	PairSearch s = there.newSearch();
	there.m_search = &s;
	s.slack += there.m_margin;
	there.beginAtRoots(s);
	m_work.kernel->search(s);
	count(s.counts);
	m_filled = true;
	// Blocks transformed for that pose are not valid for this one.
	m_work.reserveFor(m_A, m_B);
	return m_list->valid;
}

void TreeQuery::beginAtRoots(PairSearch& s) const
{
	const bool openA = m_rootA.r >= m_rootB.r;
	SubtreeList& first = openA ? s.openA : s.openB;
	BoundingBall bound = m_rootA;
	if (openA)
	{
		bound = m_rootB;
		bound.r += s.slack;
	}
	first.a[0] = first.b[0] = 0;
	first.x[0] = bound.x;
	first.y[0] = bound.y;
	first.z[0] = bound.z;
	first.r[0] = bound.r;
	first.size = 1;
}

void TreeQuery::count(const SearchCounts& counts)
{
	m_result.nodeVisits += counts.nodeVisits;
	m_result.blockPairs += counts.blockPairs;
	m_result.ballTests += counts.ballTests;
}

PairSearch TreeQuery::newSearch()
{
	PairSearch s;
	s.nodesA = m_A.nodes.data();
	s.nodesB = m_B.nodes.data();
	s.ballsA = m_bodies.ballsA;
	s.ballsB = m_bodies.ballsB;
	s.ellipsoidsB = m_bodies.ellipsoidsB;
	std::copy_n(m_bodies.R, 9, s.R);
	std::copy_n(m_bodies.t, 3, s.t);
	s.stretch = float(m_lengthening);
	s.slack = m_bodies.slack;
	s.openA = m_work.openA;
	s.openB = m_work.openB;
	s.leaves = m_work.leaves;
	s.openBatch = m_work.openBatch;
	s.ballOf = m_work.ballOf;
	s.blockOf = m_work.blockOf;
	s.columnsA = m_work.columnsA.data();
	s.epochsA = m_work.epochsA.data();
	s.moved = m_work.moved.data();
	s.marks = m_work.marks.data();
	s.centersB = m_work.movedCenters.data();
	s.movedB = hasShapes() ? m_work.movedBalls.data() : nullptr;
	s.epoch = m_work.epoch;
	s.pairA = m_work.pairA;
	s.pairB = m_work.pairB;
	s.sink = &TreeQuery::take;
	s.context = this;
	s.stop = false;
	return s;
}

int TreeQuery::copyBatch(size_t first, size_t end)
{
	const int count = int(std::min<size_t>(kPairBatch, end - first));
	std::copy_n(m_list->a.data() + first, count, m_work.pairA);
	std::copy_n(m_list->b.data() + first, count, m_work.pairB);
	return count;
}

void TreeQuery::recall()
{
	for (size_t first = 0; first < m_list->count; first += kPairBatch) take(copyBatch(first, m_list->count));
}

bool TreeQuery::listHasPatches() const
{
	return m_grouped && !m_options.sortPairs && m_list->patches() > 0 && m_list->patches() <= m_limits.patches;
}

bool TreeQuery::reusePatches()
{
	int found = 0;
	int64_t pairs = 0;
	for (int p = 0; p < m_list->patches(); ++p)
	{
		std::fill(std::begin(m_sums), std::end(m_sums), 0.0);
		for (size_t first = m_list->firstOf(p); first < m_list->firstOf(p + 1); first += kPairBatch)
		{
			evaluate(m_work.pairA, m_work.pairB, copyBatch(first, m_list->firstOf(p + 1)), m_sums);
		}
		if (m_sums[kPairs] > 0) m_work.patches[size_t(found++)] = collect(m_sums, m_damping);
		pairs += int64_t(m_sums[kPairs]);
	}
	std::fill(std::begin(m_sums), std::end(m_sums), 0.0);
	// With more pairs than a list holds, a query without a Verlet list would give one patch, too.
	if (pairs <= m_work.capacity.pairs && m_list->isGrouping(m_work.patches.data(), found)) return publishSums(found), true;
	m_list->dropPatches();
	return false;
}

bool TreeQuery::recordPatches(int groups)
{
	if (!m_list->valid || m_list->patches() > 0 || groups == 0 || groups > VerletList::Implementation::kMostPatches) return false;
	const PairIndices all{m_list->a.data(), m_list->b.data(), m_list->count, uint32_t(m_A.slotCount())};
	m_work.grouper.extend(m_work.stream, m_listed, all, m_A.balls.data(), m_list->patchOf());
	m_list->divide(groups);
	return true;
}

/// Keeps, in place, the pairs whose ellipsoids come within the margin.
int TreeQuery::cull(int count, float margin)
{
	if (!hasShapes() || m_options.listMeetingBounds) return count;
	m_bodies.margin = margin;
	pad(m_work.pairA, m_work.pairB, count);
	return m_work.kernel->cull(m_bodies, m_work.pairA, m_work.pairB, count);
}

void TreeQuery::take(int count)
{
	const int capacity = m_work.capacity.pairs;
	if (m_margin > 0)
	{
		count = cull(count, m_margin);
		m_list->append(m_work.pairA, m_work.pairB, count);
		if (m_onlyFills) return;
	}
	count = cull(count, 0);
	if (!(m_grouped || m_options.sortPairs || m_limits.pairs >= 0) || !m_result.pairListComplete)
		return evaluate(m_work.pairA, m_work.pairB, count, m_sums);
	PairStream& list = m_work.stream;
	pad(m_work.pairA, m_work.pairB, count);
	m_listed = m_work.kernel->refine(m_bodies, m_work.pairA, m_work.pairB, count, m_terms, list, m_listed);
	if (m_limits.pairs >= 0 && m_listed > m_limits.pairs) m_search->stop = true;
	if (m_listed <= capacity || m_search->stop) return;
	m_result.pairListComplete = false;
	evaluate(list.a + capacity, list.b + capacity, m_listed - capacity, m_sums);
	m_listed = capacity;
}

void TreeQuery::publishPatches(int groups)
{
	for (int p = 0; p < groups; ++p)
	{
		std::fill(std::begin(m_sums), std::end(m_sums), 0.0);
		m_work.kernel->sumGroup(m_bodies, m_work.stream, m_work.grouper.patch(), GroupNumber(p), m_listed, m_terms, m_sums);
		m_work.patches[p] = collect(m_sums, m_damping);
	}
	publishSums(groups);
}

/// Publishes the patches and their sum.
void TreeQuery::publishSums(int patches)
{
	for (int p = 0; p < patches; ++p) m_result.total.add(m_work.patches[size_t(p)]);
	m_result.patches = m_work.patches.data();
	m_result.patchCount = patches;
}

void TreeQuery::publishPairs()
{
	m_work.reservePairs();
	const bool normalsChange = m_bodies.gradientsA || m_bodies.gradientsB;
	for (int i = 0; i < m_listed; ++i) m_work.keys[i] = uint64_t(m_work.stream.a[i]) << 32 | m_work.stream.b[i];
	std::sort(m_work.keys.begin(), m_work.keys.begin() + m_listed);
	for (int i = 0; i < m_listed; ++i)
	{
		OverlapPair& pair = m_work.pairs[i];
		pair.ballA = uint32_t(m_work.keys[i] >> 32);
		pair.ballB = uint32_t(m_work.keys[i]);
		const MomentEllipsoid a = m_A.ball(pair.ballA), b = m_B.ball(pair.ballB);
		const Vec3 centerB = m_X * b.center();
		Lens lens;
		if (m_options.model == Model::Inner) lensOf(a.center(), a.R, centerB, b.R, lens);
		else
		{
			const SymmetricMatrix3 shapeB = rotated(m_X.rotation, b.shape());
			const bool met = lensOf(a.center(), a.R, a.shape(), centerB, b.R, shapeB, lens);
			if (met && normalsChange) lens.centroid = lensCentroid(lens, a.center(), a.shape(), centerB, shapeB);
		}
		pair.lens = float(lens.volume);
		pair.area = float(lens.area);
		pair.centroid = lens.centroid;
		pair.normal = lens.normal;
	}
	m_result.pairs = m_work.pairs.data();
	m_result.pairCount = m_listed;
}
}  // namespace ist
