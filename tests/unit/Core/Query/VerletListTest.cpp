// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/VerletList.h"

#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "tests/unit/Core/Query/QueryBodies.h"
#include "tests/unit/CountingAllocator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

using namespace ist;

namespace
{
/// A motion of random translations and rotations, by `step` [m] per query. The tree frames are at most about 1.5 m apart.
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
}

/// Number of queries among 60 that did not search.
int followed(const InnerSphereTree& A, const InnerSphereTree& B, double step, const QueryOptions& options, QueryWorkspace& workspace,
	VerletList& memory)
{
	QueryWorkspace other;
	Motion motion(A, B, step, 7);
	int without = 0;
	for (int tick = 0; tick < 60; ++tick)
	{
		const Pose X = motion.next();
		const OverlapResult r = queryOverlap(A, B, X, workspace, options, &memory), fresh = queryOverlap(A, B, X, other, options);
		EXPECT_EQ(r.status, QueryStatus::Ok);
		expectSamePairs(r, fresh);
		expectSameSums(r.total, fresh.total);
		without += r.nodeVisits == 0 && fresh.nodeVisits > 0;
		// A query that fills the list tests little more than one that does not.
		EXPECT_LE(double(r.nodeVisits + r.ballTests), 1.4 * double(fresh.nodeVisits + fresh.ballTests) + 100);
	}
	return without;
}
}  // namespace

TEST(VerletList, AnswersAsAFreshQueryInEveryInstructionSet)
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
				VerletList memory;
				EXPECT_GT(followed(A, B, 0.001, options, workspace, memory), 40);
			}
			QueryOptions bounds;
			bounds.sortPairs = bounds.listMeetingBounds = true;
			VerletList memory;
			EXPECT_GT(followed(A, B, 0.001, bounds, workspace, memory), 40);
		}
	}
}

// The centre of B stays in place; only its other points move.
TEST(VerletList, ATurnInPlaceUsesUpTheMargin)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2);
	QueryWorkspace workspace, other;
	QueryOptions options;
	options.sortPairs = true;
	VerletList memory;
	int without = 0;
	for (int tick = 0; tick < 200; ++tick)
	{
		Pose X;
		X.rotation = rotationMatrix(quaternionFromRotationVector(Vec3{0.3, -0.5, 0.8} * (0.0005 * tick)));
		X.translation = A.origin + Vec3{0.4, 0.2, -0.3} - X.rotation * B.origin;
		const OverlapResult r = queryOverlap(A, B, X, workspace, options, &memory), fresh = queryOverlap(A, B, X, other, options);
		expectSamePairs(r, fresh);
		expectSameSums(r.total, fresh.total);
		without += r.nodeVisits == 0 && fresh.nodeVisits > 0;
	}
	EXPECT_GT(without, 150);
}

TEST(VerletList, SearchesAnewWhereBodiesMoveFast)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2);
	QueryWorkspace workspace;
	QueryOptions options;
	options.sortPairs = true;
	VerletList memory;
	EXPECT_EQ(followed(A, B, 0.2, options, workspace, memory), 0);
	VerletList slow;
	const int slowly = followed(A, B, 0.0002, options, workspace, slow);
	EXPECT_GT(slowly, 50);
	VerletList faster;
	EXPECT_LT(followed(A, B, 0.004, options, workspace, faster), slowly);
}

TEST(VerletList, LastsLongerWhereItsFillLooksAhead)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2);
	QueryWorkspace workspace, other;
	VerletList memory;
	QueryOptions options;
	options.sortPairs = true;
	int searches = 0;
	const Vec3 step = normalized(Vec3{1, 2, -1}) * 0.002;
	for (int tick = 0; tick < 200; ++tick)
	{
		const Pose X{{}, A.origin - B.origin + step * (tick - 100)};
		const OverlapResult r = queryOverlap(A, B, X, workspace, options, &memory), fresh = queryOverlap(A, B, X, other, options);
		expectSamePairs(r, fresh);
		expectSameSums(r.total, fresh.total);
		searches += r.nodeVisits > 0;
	}
	EXPECT_LT(searches, 25);
}

TEST(VerletList, WithoutRoomEachQuerySearches)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2);
	QueryWorkspace workspace;
	QueryOptions options;
	options.sortPairs = true;
	for (const int room : {-1, 0, 100})
	{
		VerletList memory(room);
		EXPECT_EQ(followed(A, B, 0.001, options, workspace, memory), 0);
	}
}

TEST(VerletList, NoticesOtherTreesAndOtherQuestions)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2), C = cloudBody(700, 3);
	QueryWorkspace workspace, other;
	VerletList memory;
	QueryOptions packed;
	packed.model = Model::Inner;
	for (int repeat = 0; repeat < 3; ++repeat)
	{
		for (int still = 0; still < 3; ++still) queryOverlap(A, B, Pose{}, workspace, {}, &memory);
		EXPECT_EQ(queryOverlap(A, B, Pose{}, workspace, {}, &memory).nodeVisits, 0);
		expectSameSums(queryOverlap(A, C, Pose{}, workspace, {}, &memory).total, queryOverlap(A, C, Pose{}, other).total);
		expectSameSums(queryOverlap(A, B, Pose{}, workspace, packed, &memory).total, queryOverlap(A, B, Pose{}, other, packed).total);
	}
	for (int still = 0; still < 3; ++still) queryOverlap(A, B, Pose{}, workspace, {}, &memory);
	memory.forget();
	// The last pose belonged to other trees, so it is no measure of the motion of these trees.
	Pose far;
	far.translation.x = 0.5;
	EXPECT_GT(queryOverlap(A, B, far, workspace, {}, &memory).nodeVisits, 0);
	queryOverlap(A, B, far, workspace, {}, &memory);
	EXPECT_EQ(queryOverlap(A, B, far, workspace, {}, &memory).nodeVisits, 0);
	Pose bad;
	bad.translation.x = NAN;
	EXPECT_EQ(queryOverlap(A, B, bad, workspace, {}, &memory).status, QueryStatus::InvalidPose);
	expectSameSums(queryOverlap(A, B, Pose{}, workspace, {}, &memory).total, queryOverlap(A, B, Pose{}, other).total);
}

TEST(VerletList, GroupsAndGatesAsWithout)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2);
	QueryWorkspace workspace, other;
	VerletList memory;
	QueryOptions options;
	options.requireInnerOverlap = true;
	Motion motion(A, B, 0.001, 3);
	for (int tick = 0; tick < 30; ++tick)
	{
		const Pose X = motion.next();
		const OverlapResult r = queryOverlap(A, B, X, workspace, options, &memory), fresh = queryOverlap(A, B, X, other, options);
		expectSameSums(r.total, fresh.total);
		EXPECT_GT(fresh.patchCount, 1);
		OverlapIntegrals sum;
		for (int p = 0; p < r.patchCount; ++p) sum.add(r.patches[p]);
		expectSameSums(sum, fresh.total);
	}
}

TEST(VerletList, RemembersThePatchesOfItsPairs)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2);
	QueryWorkspace workspace, other;
	VerletList memory;
	QueryOptions options;
	options.stiffness = true;
	Motion motion(A, B, 0.0005, 11);
	int compared = 0, older = 0;
	for (int tick = 0; tick < 60; ++tick)
	{
		const Pose X = motion.next();
		const OverlapResult r = queryOverlap(A, B, X, workspace, options, &memory);
		const std::vector<OverlapIntegrals> patches(r.patches, r.patches + r.patchCount);
		// At the same pose the list alone answers, if it is valid.
		const OverlapResult again = queryOverlap(A, B, X, workspace, options, &memory), fresh = queryOverlap(A, B, X, other, options);
		expectSameSums(again.total, fresh.total);
		if (again.nodeVisits > 0) continue;
		double scale = 0;
		for (int i = 0; i < 6; ++i) scale = std::max(scale, std::fabs(fresh.total.stiffnessA(i, i)));
		for (int i = 0; i < 21; ++i) EXPECT_NEAR(again.total.stiffnessA.m[i], fresh.total.stiffnessA.m[i], 1e-5 * scale);
		ASSERT_EQ(again.patchCount, int(patches.size())) << tick;
		for (int p = 0; p < again.patchCount; ++p) expectSameSums(again.patches[p], patches[size_t(p)]);
		compared += again.patchCount > 1;
		older += again.patchCount != fresh.patchCount || again.patches[0].pairs != fresh.patches[0].pairs;
	}
	EXPECT_GT(compared, 40);
	EXPECT_GT(older, 10) << "they were grouped anew in every query";
}

namespace
{
/// Share of the volume that remains when normals cancel within each patch.
double alignment(const OverlapResult& r)
{
	double sum = 0;
	for (int p = 0; p < r.patchCount; ++p) sum += norm(r.patches[p].normalA.force);
	return r.total.volume > 0 ? sum / r.total.volume : 1;
}

/// A row of balls across x, spaced so that each meets only the ball opposite to it.
void addWall(std::vector<MomentEllipsoid>& balls, double x, double normal, int count)
{
	for (int i = 0; i < count; ++i) balls.push_back(ballAt({x, 0.25 * i, 0}, {normal, 0, 0}));
}

/// A grid of such balls across z. Their normals point to its middle from both sides; for -1 they point away from it.
InnerSphereTree slopes(double sign)
{
	std::vector<MomentEllipsoid> balls;
	for (int i = 0; i < 12; ++i)
		for (int j = 0; j < 12; ++j) balls.push_back(ballAt({0.25 * i, 0.25 * j, 0}, normalized(Vec3{i < 6 ? 2.0 : -2.0, 0, 1}) * sign));
	return bodyOf(balls);
}

/// The pose is tilted a little, so that a corner touches first.
Pose above(double height) { return {rotationMatrix(quaternionFromRotationVector({-0.002, 0.002, 0})), {0, 0, height}}; }
}  // namespace

// A peg leaves one wall of its hole and touches the other wall. The new contact must not become part of the first wall's patch.
TEST(VerletList, GroupsAnewWhatComesToTouchOnTheOtherSide)
{
	constexpr int kFirst = 12;
	QueryCapacity capacity;
	capacity.patches = 32;  // one patch for each pair
	for (const int second : {1, kFirst})
	{
		std::vector<MomentEllipsoid> hole, peg;
		addWall(hole, -1, 1, kFirst);
		addWall(hole, 1, -1, second);
		addWall(peg, -0.82, -1, kFirst);
		addWall(peg, 0.82, 1, second);
		const InnerSphereTree A = bodyOf(hole), B = bodyOf(peg);
		QueryWorkspace workspace(capacity), other(capacity);
		VerletList memory;
		int without = 0;
		for (double at = -0.03; at < 0.002; at += 0.002)
		{
			Pose X;
			X.translation.x = at;
			const OverlapResult r = queryOverlap(A, B, X, workspace, {}, &memory), fresh = queryOverlap(A, B, X, other);
			expectSameSums(r.total, fresh.total);
			ASSERT_NEAR(alignment(fresh), 1, 1e-5);
			EXPECT_GE(alignment(r), 0.9 - 1e-5) << second << " at " << at;
			without += r.nodeVisits == 0 && fresh.total.pairs == kFirst + second;
		}
		EXPECT_GT(without, 3);
	}
}

// A list that is filled while nothing touches has no patches yet. The first pair that touches must not define the only patch.
TEST(VerletList, GroupsAnewWhileBodiesComeToTouch)
{
	const InnerSphereTree A = slopes(1), B = slopes(-1);
	QueryWorkspace workspace, other;
	VerletList memory;
	int without = 0;
	for (double height = 0.215; height > 0.19; height -= 0.001)
	{
		const Pose X = above(height);
		const OverlapResult r = queryOverlap(A, B, X, workspace, {}, &memory), fresh = queryOverlap(A, B, X, other);
		expectSameSums(r.total, fresh.total);
		EXPECT_GE(alignment(r), 0.9 * alignment(fresh) - 1e-6) << height;
		without += r.nodeVisits == 0 && fresh.total.pairs > 0;
	}
	EXPECT_GT(without, 5);
}

TEST(VerletList, AnswersWhatIsAskedThoughItWasAskedOtherwiseBefore)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2);
	QueryCapacity few;
	few.patches = 2;
	QueryWorkspace workspace, narrow(few), other;
	VerletList memory;
	Motion motion(A, B, 0.0005, 13);
	int without = 0;
	for (int tick = 0; tick < 60; ++tick)
	{
		const Pose X = motion.next();
		QueryOptions options;
		options.sortPairs = tick % 3 == 1;
		options.patches = tick % 5 != 2;
		const OverlapResult r = queryOverlap(A, B, X, tick % 4 == 3 ? narrow : workspace, options, &memory),
							fresh = queryOverlap(A, B, X, other, options);
		expectSamePairs(r, fresh);
		expectSameSums(r.total, fresh.total);
		EXPECT_LE(r.patchCount, tick % 4 == 3 ? 2 : 8);
		EXPECT_TRUE(options.patches || r.patchCount == 1);
		without += r.nodeVisits == 0;
	}
	EXPECT_GT(without, 40);
}

TEST(VerletList, IsNotFilledWhileItsRoomIsTooSmall)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2);
	QueryWorkspace workspace, other;
	Pose X;
	const int found = int(queryOverlap(A, B, X, other).total.pairs);
	VerletList memory(found);
	int more = 0;
	for (int tick = 0; tick < 20; ++tick)
	{
		X.translation.x += 0.0002;
		const OverlapResult r = queryOverlap(A, B, X, workspace, {}, &memory), fresh = queryOverlap(A, B, X, other);
		EXPECT_GT(r.nodeVisits, 0);
		more += r.ballTests > fresh.ballTests;
	}
	EXPECT_LE(more, 1) << "searches with a margin, for nothing";
	// At this distance half of the contacts are gone.
	X.translation.x = 1;
	int without = 0;
	for (int tick = 0; tick < 40; ++tick)
	{
		X.translation.x += 0.0002;
		without += queryOverlap(A, B, X, workspace, {}, &memory).nodeVisits == 0;
	}
	EXPECT_GT(without, 15);
}

TEST(VerletList, AListThatIsTooShortIsCutAsWithout)
{
	const InnerSphereTree A = slopes(1), B = slopes(-1);
	QueryCapacity capacity;
	capacity.pairs = 70;  // half of the pairs that touch in the end
	QueryWorkspace workspace(capacity), other(capacity);
	VerletList memory;
	int whole = 0, cut = 0;
	for (double height = 0.215; height > 0.19; height -= 0.0005)
	{
		const Pose X = above(height);
		const OverlapResult r = queryOverlap(A, B, X, workspace, {}, &memory), fresh = queryOverlap(A, B, X, other);
		expectSameSums(r.total, fresh.total);
		EXPECT_EQ(r.pairListComplete, fresh.pairListComplete);
		EXPECT_TRUE(fresh.pairListComplete || r.patchCount == 1);
		if (r.nodeVisits > 0 || fresh.total.pairs == 0) continue;
		++(fresh.pairListComplete ? whole : cut);
	}
	EXPECT_GT(whole, 5);
	EXPECT_GT(cut, 5);
}

TEST(VerletList, AListThatIsFullByAFewPairsIsCutAsWithout)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2);
	QueryWorkspace measuring;
	std::vector<Pose> poses;
	std::vector<int64_t> pairs;
	Motion motion(A, B, 0.0005, 5);
	for (int tick = 0; tick < 100; ++tick)
	{
		poses.push_back(motion.next());
		pairs.push_back(queryOverlap(A, B, poses.back(), measuring).total.pairs);
	}
	QueryCapacity capacity;  // number of pairs that is exceeded in some queries, by too few pairs to group anew
	capacity.pairs = int(*std::min_element(pairs.begin(), pairs.end()) + *std::max_element(pairs.begin(), pairs.end())) / 2;
	QueryWorkspace workspace(capacity), other(capacity);
	VerletList memory;
	int cut = 0;
	for (const Pose& X : poses)
	{
		const OverlapResult r = queryOverlap(A, B, X, workspace, {}, &memory), fresh = queryOverlap(A, B, X, other);
		expectSameSums(r.total, fresh.total);
		EXPECT_EQ(r.pairListComplete, fresh.pairListComplete);
		cut += r.nodeVisits == 0 && !fresh.pairListComplete;
	}
	EXPECT_GT(cut, 5);
}

TEST(VerletList, AllocatesNothing)
{
	const InnerSphereTree A = cloudBody(900, 1), B = cloudBody(1100, 2);
	QueryWorkspace workspace;
	VerletList memory;
	queryOverlap(A, B, Pose{}, workspace);
	const long before = allocationCount();
	Motion motion(A, B, 0.001, 5);
	for (int tick = 0; tick < 50; ++tick) queryOverlap(A, B, motion.next(), workspace, {}, &memory);
	EXPECT_EQ(allocationCount(), before);
}
