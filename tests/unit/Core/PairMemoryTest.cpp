// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/PairMemory.h"

#include "tests/unit/Core/QueryBodies.h"
#include "tests/unit/CountingAllocator.h"

#include <gtest/gtest.h>

#include <random>

using namespace ist;

namespace
{
/// A motion of random translations and turns, each query `step` [m] further; tree frames at most about 1.5 apart.
class Motion
{
public:
	Motion(const InnerSphereTree& A, const InnerSphereTree& B, double step, unsigned seed) : m_A(A), m_B(B), m_step(step), m_random(seed)
	{
		m_X.rotation = rotationMatrix(quaternionFromRotationVector({m_uniform(m_random), 2, m_uniform(m_random)}));
		m_at = {0.7 * m_uniform(m_random), 0.7 * m_uniform(m_random), 0.7 * m_uniform(m_random)};
		m_velocity = {m_uniform(m_random), m_uniform(m_random), m_uniform(m_random)};
	}
	Pose next()
	{
		m_velocity += Vec3{m_uniform(m_random), m_uniform(m_random), m_uniform(m_random)} * 0.2 - m_at * 0.2;
		m_at += normalized(m_velocity) * m_step;
		const Vec3 turn{m_uniform(m_random), m_uniform(m_random), m_uniform(m_random)};
		m_X.rotation = rotationMatrix(quaternionFromRotationVector(turn * (0.3 * m_step))) * m_X.rotation;
		m_X.translation = m_A.origin + m_at - m_X.rotation * m_B.origin;
		return m_X;
	}

private:
	const InnerSphereTree &m_A, &m_B;
	double m_step;
	std::mt19937 m_random;
	std::uniform_real_distribution<double> m_uniform{-1, 1};
	Pose m_X;
	Vec3 m_at, m_velocity;
};

void expectSamePairs(const OverlapResult& a, const OverlapResult& b)
{
	ASSERT_EQ(a.pairCount, b.pairCount);
	for (int i = 0; i < a.pairCount; ++i)
	{
		ASSERT_EQ(a.pairs[i].ballA, b.pairs[i].ballA);
		ASSERT_EQ(a.pairs[i].ballB, b.pairs[i].ballB);
	}
}

void expectSameSums(const OverlapIntegrals& a, const OverlapIntegrals& b)
{
	EXPECT_EQ(a.pairs, b.pairs);
	const double tolerance = 1e-5 * b.volume + 1e-15;
	EXPECT_NEAR(a.volume, b.volume, tolerance);
	expectNear(a.normalA.force, b.normalA.force, tolerance);
	expectNear(a.normalB.torque, b.normalB.torque, tolerance);
	expectNear(a.line.force, b.line.force, tolerance);
	EXPECT_NEAR(a.spread, b.spread, 1e-5 * b.spread + 1e-30);
}

/// Queries that did not search, of 60.
int followed(const InnerSphereTree& A, const InnerSphereTree& B, double step, const QueryOptions& options, QueryWorkspace& workspace,
			 PairMemory& memory)
{
	QueryWorkspace other;
	Motion motion(A, B, step, 7);
	int without = 0;
	for (int tick = 0; tick < 60; ++tick)
	{
		const Pose X = motion.next();
		const OverlapResult r = queryOverlap(A, B, X, workspace, memory, options), fresh = queryOverlap(A, B, X, other, options);
		EXPECT_EQ(r.status, QueryStatus::Ok);
		expectSamePairs(r, fresh);
		expectSameSums(r.total, fresh.total);
		without += r.nodeVisits == 0 && fresh.nodeVisits > 0;
		// A query that fills the memory looks at little more than one that does not.
		EXPECT_LE(double(r.nodeVisits + r.ballTests), 1.4 * double(fresh.nodeVisits + fresh.ballTests) + 100);
	}
	return without;
}
}  // namespace

TEST(PairMemory, AnswersAsAFreshQueryInEveryInstructionSet)
{
	for (const InstructionSet set : kInstructionSets)
	{
		if (!isAvailable(set)) continue;
		SCOPED_TRACE(toString(set));
		QueryWorkspace workspace({}, set);
		for (const Vec3& origin : {Vec3{}, Vec3{1000, -2000, 500}})
		{
			const InnerSphereTree A = cloudBody(900, 1, origin), B = cloudBody(1100, 2, origin * -0.5);
			for (const Model model : {Model::Law, Model::Cell, Model::Inner})
			{
				QueryOptions options;
				options.model = model;
				options.sortPairs = true;
				PairMemory memory;
				EXPECT_GT(followed(A, B, 0.001, options, workspace, memory), 40);
			}
			QueryOptions bounds;
			bounds.sortPairs = bounds.listMeetingBounds = true;
			PairMemory memory;
			EXPECT_GT(followed(A, B, 0.001, bounds, workspace, memory), 40);
		}
	}
}

TEST(PairMemory, SearchesAnewWhereBodiesMoveFast)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2);
	QueryWorkspace workspace;
	QueryOptions options;
	options.sortPairs = true;
	PairMemory memory;
	EXPECT_EQ(followed(A, B, 0.2, options, workspace, memory), 0);
	PairMemory slow;
	const int slowly = followed(A, B, 0.0002, options, workspace, slow);
	EXPECT_GT(slowly, 50);
	PairMemory faster;
	EXPECT_LT(followed(A, B, 0.004, options, workspace, faster), slowly);
}

TEST(PairMemory, WithoutRoomEachQuerySearches)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2);
	QueryWorkspace workspace;
	QueryOptions options;
	options.sortPairs = true;
	for (const int room : {-1, 0, 100})
	{
		PairMemory memory(room);
		EXPECT_EQ(followed(A, B, 0.001, options, workspace, memory), 0);
	}
}

TEST(PairMemory, NoticesOtherTreesAndOtherQuestions)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2), C = cloudBody(700, 3);
	QueryWorkspace workspace, other;
	PairMemory memory;
	QueryOptions packed;
	packed.model = Model::Inner;
	for (int repeat = 0; repeat < 3; ++repeat)
	{
		for (int still = 0; still < 3; ++still) queryOverlap(A, B, Pose{}, workspace, memory);
		EXPECT_EQ(queryOverlap(A, B, Pose{}, workspace, memory).nodeVisits, 0);
		expectSameSums(queryOverlap(A, C, Pose{}, workspace, memory).total, queryOverlap(A, C, Pose{}, other).total);
		expectSameSums(queryOverlap(A, B, Pose{}, workspace, memory, packed).total, queryOverlap(A, B, Pose{}, other, packed).total);
	}
	for (int still = 0; still < 3; ++still) queryOverlap(A, B, Pose{}, workspace, memory);
	memory.forget();
	EXPECT_GT(queryOverlap(A, B, Pose{}, workspace, memory).nodeVisits, 0);
	Pose bad;
	bad.translation.x = NAN;
	EXPECT_EQ(queryOverlap(A, B, bad, workspace, memory).status, QueryStatus::InvalidPose);
	expectSameSums(queryOverlap(A, B, Pose{}, workspace, memory).total, queryOverlap(A, B, Pose{}, other).total);
}

TEST(PairMemory, GroupsAndGatesAsWithout)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2);
	QueryWorkspace workspace, other;
	PairMemory memory;
	QueryOptions options;
	options.gate = true;
	Motion motion(A, B, 0.001, 3);
	for (int tick = 0; tick < 30; ++tick)
	{
		const Pose X = motion.next();
		const OverlapResult r = queryOverlap(A, B, X, workspace, memory, options), fresh = queryOverlap(A, B, X, other, options);
		expectSameSums(r.total, fresh.total);
		EXPECT_GT(fresh.patchCount, 1);
		OverlapIntegrals sum;
		for (int p = 0; p < r.patchCount; ++p) sum.add(r.patches[p]);
		expectSameSums(sum, fresh.total);
	}
}

TEST(PairMemory, RemembersThePatchesOfTheQueryThatFilledIt)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2);
	QueryWorkspace workspace, other;
	PairMemory memory;
	QueryOptions options;
	options.stiffness = true;
	Motion motion(A, B, 0.0005, 11);
	std::vector<OverlapIntegrals> filled;
	int compared = 0;
	for (int tick = 0; tick < 60; ++tick)
	{
		const Pose X = motion.next();
		const OverlapResult r = queryOverlap(A, B, X, workspace, memory, options);
		if (r.nodeVisits > 0) filled.assign(r.patches, r.patches + r.patchCount);
		// At the same pose the memory alone answers, if it holds.
		const OverlapResult again = queryOverlap(A, B, X, workspace, memory, options), fresh = queryOverlap(A, B, X, other, options);
		expectSameSums(again.total, fresh.total);
		if (again.nodeVisits > 0) continue;
		for (int i = 0; i < 21; ++i) EXPECT_NEAR(again.total.stiffnessA.m[i], fresh.total.stiffnessA.m[i], 1e-4 * norm(fresh.total.areaVector) + 1e-9);
		ASSERT_EQ(again.patchCount, int(filled.size())) << tick;
		// A pair or two in a thousand have come or gone since.
		for (int p = 0; p < again.patchCount; ++p) EXPECT_NEAR(double(again.patches[p].pairs), double(filled[size_t(p)].pairs), 5 + 0.05 * double(filled[size_t(p)].pairs));
		compared += again.patchCount > 1;
	}
	EXPECT_GT(compared, 40);
}

TEST(PairMemory, AllocatesNothing)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2);
	QueryWorkspace workspace;
	PairMemory memory;
	queryOverlap(A, B, Pose{}, workspace);
	const long before = allocationCount();
	Motion motion(A, B, 0.001, 5);
	for (int tick = 0; tick < 50; ++tick) queryOverlap(A, B, motion.next(), workspace, memory);
	EXPECT_EQ(allocationCount(), before);
}
