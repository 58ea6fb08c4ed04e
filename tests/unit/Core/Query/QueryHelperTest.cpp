// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/QueryHelper.h"

#include "tests/unit/Core/Query/QueryBodies.h"
#include "tests/unit/CountingAllocator.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

using namespace ist;

namespace
{
void expectSame(const OverlapResult& a, const OverlapResult& b)
{
	ASSERT_EQ(a.status, b.status);
	EXPECT_EQ(a.total.pairs, b.total.pairs);
	EXPECT_EQ(a.nodeVisits, b.nodeVisits);
	EXPECT_EQ(a.ballTests, b.ballTests);
	EXPECT_EQ(a.patchCount, b.patchCount);
	const double tolerance = 1e-5 * b.total.volume + 1e-15;
	EXPECT_NEAR(a.total.volume, b.total.volume, tolerance);
	expectNear(a.total.normalA.force, b.total.normalA.force, tolerance);
	expectNear(a.total.normalB.torque, b.total.normalB.torque, tolerance);
	expectNear(a.total.line.force, b.total.line.force, tolerance);
	ASSERT_EQ(a.pairCount, b.pairCount);
	for (int i = 0; i < a.pairCount; ++i)
	{
		ASSERT_EQ(a.pairs[i].ballA, b.pairs[i].ballA);
		ASSERT_EQ(a.pairs[i].ballB, b.pairs[i].ballB);
	}
}

/// Programs that want all cores.
class Neighbours
{
public:
	explicit Neighbours(int count)
	{
		for (int i = 0; i < count; ++i)
			m_threads.emplace_back([this] {
				while (!m_stop) m_work.fetch_add(1, std::memory_order_relaxed);
			});
	}
	~Neighbours()
	{
		m_stop = true;
		for (std::thread& t : m_threads) t.join();
	}

private:
	std::atomic<bool> m_stop{false};
	std::atomic<long> m_work{0};
	std::vector<std::thread> m_threads;
};
}  // namespace

TEST(QueryHelper, FindsTheSameAsAQueryAlone)
{
	const InnerSphereTree A = cloudBody(3000, 1, {300, 0, -40}), B = cloudBody(3500, 2);
	for (const InstructionSet set : kInstructionSets)
	{
		if (!isAvailable(set)) continue;
		SCOPED_TRACE(toString(set));
		QueryWorkspace shared({}, set), alone({}, set);
		QueryHelper helper;
		shared.setHelper(&helper);
		std::mt19937 random(6);
		for (int trial = 0; trial < 200 && (trial < 12 || helper.partsDone() == 0); ++trial)
		{
			QueryOptions options;
			options.model = trial % 3 == 0 ? Model::Law : trial % 3 == 1 ? Model::Inner : Model::Cell;
			options.patches = trial % 2;
			options.sortPairs = trial % 4 == 0;
			const Pose X = randomPose(random, A, B, 0.5);
			expectSame(queryOverlap(A, B, X, shared, options), queryOverlap(A, B, X, alone, options));
		}
		// How many depends on whether the machine had a core to spare.
		RecordProperty("parts_done", std::to_string(helper.partsDone()));
	}
}

TEST(QueryHelper, IsNotNeededWhereOtherProgramsHoldTheCores)
{
	const InnerSphereTree A = cloudBody(2000, 1), B = cloudBody(2500, 2);
	QueryWorkspace shared, alone;
	const Neighbours neighbours(2 * int(std::thread::hardware_concurrency()) + 2);
	QueryHelper helper({}, 5000);
	shared.setHelper(&helper);
	std::mt19937 random(7);
	// Until it has lost its processor within a part a few times, where it ever does.
	for (int trial = 0; trial < 400 && (trial < 60 || helper.partsLate() < 3); ++trial)
	{
		const Pose X = randomPose(random, A, B, 0.5);
		expectSame(queryOverlap(A, B, X, shared), queryOverlap(A, B, X, alone));
	}
	RecordProperty("partsLate", int(helper.partsLate()));
}

// Bit for bit one of two answers, alone or in parts: what a part finds lies in its place, whoever found it.
TEST(QueryHelper, AnswersDoNotDependOnWhoSearchedWhat)
{
	const InnerSphereTree A = cloudBody(3000, 1), B = cloudBody(3500, 2);
	QueryWorkspace shared;
	QueryHelper helper;
	shared.setHelper(&helper);
	for (const bool patches : {false, true})
	{
		QueryOptions options;
		options.patches = patches;
		std::set<std::vector<double>> answers;
		const auto ask = [&](int times) {
			for (int i = 0; i < times; ++i)
			{
				const OverlapResult r = queryOverlap(A, B, Pose{}, shared, options);
				std::vector<double> answer;
				for (int p = 0; p < r.patchCount; ++p)
					answer.insert(answer.end(), {r.patches[p].volume, r.patches[p].normalA.force.x, r.patches[p].normalB.torque.z});
				answers.insert(answer);
			}
		};
		ask(100);
		{
			const Neighbours neighbours{static_cast<int>(std::thread::hardware_concurrency())};
			ask(50);
		}
		EXPECT_FALSE(answers.begin()->empty());
		EXPECT_LE(answers.size(), 2u) << (patches ? "in patches" : "as one");
	}
	RecordProperty("parts_done", std::to_string(helper.partsDone()));
}

TEST(QueryHelper, LetsGoOfTreesThatWillGo)
{
	QueryWorkspace shared, alone;
	QueryHelper helper({}, 0);
	shared.setHelper(&helper);
	for (unsigned seed = 0; seed < 6; ++seed)
	{
		const auto A = std::make_unique<InnerSphereTree>(cloudBody(1500, seed)),
				   B = std::make_unique<InnerSphereTree>(cloudBody(1500, seed + 50));
		expectSame(queryOverlap(*A, *B, Pose{}, shared), queryOverlap(*A, *B, Pose{}, alone));
		helper.settle();
	}
}

TEST(QueryHelper, CapacityCutsTheListAsAlone)
{
	const InnerSphereTree A = cloudBody(2000, 1), B = cloudBody(2000, 2);
	QueryCapacity tight;
	tight.pairs = 700;
	QueryWorkspace shared(tight), alone(tight), small;
	QueryHelper helper(tight);
	shared.setHelper(&helper);
	QueryOptions options;
	options.sortPairs = true;
	for (int trial = 0; trial < 5; ++trial)
	{
		const OverlapResult r = queryOverlap(A, B, Pose{}, shared, options), expected = queryOverlap(A, B, Pose{}, alone, options);
		EXPECT_FALSE(r.pairListComplete);
		EXPECT_EQ(r.total.pairs, expected.total.pairs);
		EXPECT_EQ(r.pairCount, expected.pairCount);
		EXPECT_EQ(r.nodeVisits, expected.nodeVisits);
		EXPECT_EQ(r.ballTests, expected.ballTests);
		EXPECT_NEAR(r.total.volume, expected.total.volume, 1e-5 * expected.total.volume);
	}
	// With less room than the workspace it is of no use, and harmless.
	small.setHelper(&helper);
	const int64_t before = helper.partsDone();
	queryOverlap(A, B, Pose{}, small, options);
	EXPECT_EQ(helper.partsDone(), before);
}

TEST(QueryHelper, AllocatesNothing)
{
	const InnerSphereTree A = cloudBody(2000, 1), B = cloudBody(2000, 2);
	QueryWorkspace shared;
	QueryHelper helper;
	shared.setHelper(&helper);
	EXPECT_EQ(queryOverlap(A, B, {{}, {10, 0, 0}}, shared).total.pairs, 0);
	const long before = allocationCount();
	for (int i = 0; i < 20; ++i) queryOverlap(A, B, Pose{}, shared);
	helper.settle();
	EXPECT_EQ(allocationCount(), before);
}
