// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Loop/WorldMirror.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <random>
#include <thread>

#include "DeviceBridge/Loop/ModelAge.h"
#include "tests/unit/CountingAllocator.h"

using namespace devicebridge;
using ist::Vec3;

namespace
{
constexpr std::int64_t kMs = 1'000'000;

/// A hand without physics. In each tick it gives every body that is not leaving a small integer impulse, so that sums are exact.
struct GivingHand
{
	WorldMirror& mirror;
	SpentImpulse copies[kMirroredBodies];
	double given[kMirroredBodies] = {};  ///< impulse given to all bodies of the slot [N s]
	std::uint64_t ticks = 0;

	explicit GivingHand(WorldMirror& m) : mirror(m) {}
	void tick(double impulse)
	{
		mirror.fetch();
		HandPost& post = mirror.post();
		post.tick = ++ticks;
		for (int slot = 0; slot < kMirroredBodies; ++slot)
		{
			const MirroredBody& body = mirror.snapshot().bodies[slot];
			SpentImpulse& copy = copies[slot];
			if (copy.epoch != body.epoch) copy = {}, copy.epoch = body.epoch;
			if (body.epoch != 0 && !body.leaving)
			{
				copy.impulse.force.x += impulse;
				given[slot] += impulse;
			}
			copy.area = copy.area + 1e-3 * copy.impulse;
			copy.seconds += 1e-3;
			copy.released = body.leaving;
			post.bodies[slot] = copy;
		}
		mirror.send();
	}
};

struct TakingWorld
{
	WorldMirror& mirror;
	double taken[kMirroredBodies] = {};
	int released = 0;

	explicit TakingWorld(WorldMirror& m) : mirror(m) {}
	void step(double period)
	{
		mirror.collect();
		for (int slot = 0; slot < kMirroredBodies; ++slot) taken[slot] += mirror.taken(slot).impulse.force.x;
		for (int slot = 0; slot < kMirroredBodies; ++slot) released += mirror.releaseIfDone(slot);
		mirror.publish(period);
	}
};
}  // namespace

TEST(TripleBuffer, TheReaderSeesTheLatestWholeValue)
{
	struct Value
	{
		std::uint64_t words[64];
	};
	auto buffer = std::make_unique<TripleBuffer<Value>>();
	EXPECT_FALSE(buffer->fetch());
	constexpr std::uint64_t kLast = 200'000;
	std::uint64_t replaced = 0, taken = 0;
	std::thread writer([&] {
		for (std::uint64_t i = 1; i <= kLast; ++i)
		{
			for (std::uint64_t& word : buffer->writable().words) word = i;
			replaced += buffer->publish();
		}
	});
	std::uint64_t seen = 0, torn = 0, backwards = 0;
	while (seen < kLast)
	{
		if (!buffer->fetch()) continue;
		++taken;
		const Value& value = buffer->readable();
		for (const std::uint64_t word : value.words) torn += word != value.words[0];
		backwards += value.words[0] <= seen;
		seen = value.words[0];
	}
	writer.join();
	EXPECT_EQ(torn + backwards, 0U);
	EXPECT_EQ(taken + replaced, kLast) << "the writer knows which values the reader never takes";
	EXPECT_FALSE(buffer->fetch());
}

TEST(WorldMirror, TheWorldTakesExactlyWhatTheHandGave)
{
	auto mirror = std::make_unique<WorldMirror>();
	GivingHand hand(*mirror);
	TakingWorld world(*mirror);
	int bodies[3] = {};
	const int first = mirror->admit(&bodies[0]), second = mirror->admit(&bodies[1]);
	ASSERT_TRUE(first >= 0 && second >= 0 && first != second);
	EXPECT_EQ(mirror->find(&bodies[1]), second);
	EXPECT_EQ(mirror->find(&bodies[2]), -1);
	world.step(0.01);
	for (int i = 0; i < 10; ++i) hand.tick(2);
	EXPECT_EQ(hand.given[first], 20);
	EXPECT_EQ(world.taken[first], 0);
	world.step(0.01);
	EXPECT_EQ(world.taken[first], 20);
	EXPECT_EQ(world.taken[second], 20);
	world.step(0.01);  // nothing new was posted
	EXPECT_EQ(world.taken[first], 20);
}

TEST(WorldMirror, ASteadyForceComesHalfTooEarly)
{
	auto mirror = std::make_unique<WorldMirror>();
	GivingHand hand(*mirror);
	TakingWorld world(*mirror);
	int body = 0;
	const int slot = mirror->admit(&body);
	world.step(0.2);
	for (const double impulse : {1.0, 1.0, 5.0})
	{
		for (int i = 0; i < 200; ++i) hand.tick(impulse);
		world.step(0.2);
		EXPECT_NEAR(mirror->taken(slot).seconds, 0.2, 1e-12);
		// Impulse i of n was missing for (i - 1)/n of the time: the mean is (n - 1)/2n.
		EXPECT_NEAR(mirror->taken(slot).share, 199.0 / 400, 1e-9);
	}
	for (int i = 0; i < 200; ++i) hand.tick(i == 49 ? 3 : 0);
	world.step(0.2);
	EXPECT_NEAR(mirror->taken(slot).share, 49.0 / 200, 1e-9);
}

TEST(WorldMirror, ATenantLeavesWithItsLastImpulse)
{
	auto mirror = std::make_unique<WorldMirror>();
	GivingHand hand(*mirror);
	TakingWorld world(*mirror);
	int bodies[2] = {};
	const int slot = mirror->admit(&bodies[0]);
	world.step(0.01);
	for (int i = 0; i < 5; ++i) hand.tick(1);
	mirror->leave(slot);
	world.step(0.01);
	EXPECT_EQ(world.released, 0);  // the hand does not know of it yet
	EXPECT_EQ(world.taken[slot], 5);
	for (int i = 0; i < 5; ++i) hand.tick(1);
	EXPECT_EQ(hand.given[slot], 5);
	world.step(0.01);
	EXPECT_EQ(world.released, 1);
	EXPECT_EQ(mirror->find(&bodies[0]), -1);
	EXPECT_EQ(mirror->admit(&bodies[1]), slot);
	world.step(0.01);  // the post still refers to the previous body
	EXPECT_EQ(world.taken[slot], 5);
	hand.tick(1);
	world.step(0.01);
	EXPECT_EQ(world.taken[slot], 6);
}

TEST(WorldMirror, ManyTenantsAreRefusedWhenAllSlotsAreTaken)
{
	auto mirror = std::make_unique<WorldMirror>();
	int bodies[kMirroredBodies + 1] = {};
	for (int i = 0; i < kMirroredBodies; ++i) EXPECT_GE(mirror->admit(&bodies[i]), 0);
	EXPECT_EQ(mirror->admit(&bodies[kMirroredBodies]), -1);
}

TEST(WorldMirror, WhatIsClearedIsEmptyAndTheNextTenantIsAnother)
{
	auto mirror = std::make_unique<WorldMirror>();
	GivingHand hand(*mirror);
	TakingWorld world(*mirror);
	auto tree = std::make_shared<const ist::InnerSphereTree>();
	const std::weak_ptr<const ist::InnerSphereTree> kept = tree;
	int body = 0;
	const int slot = mirror->admit(&body, {std::move(tree)});
	mirror->writable().contactCount = mirror->writable().toolContactCount = 3;
	world.step(0.01);
	mirror->writable().contactCount = mirror->writable().toolContactCount = 3;
	hand.tick(1);
	const std::uint64_t epoch = mirror->snapshot().bodies[slot].epoch;
	mirror->clear();
	EXPECT_TRUE(kept.expired());
	EXPECT_EQ(mirror->find(&body), -1);
	hand.tick(1);
	EXPECT_EQ(hand.given[slot], 1);
	EXPECT_EQ(mirror->snapshot().contactCount + mirror->snapshot().toolContactCount, 0);
	for (const MirroredBody& seen : mirror->snapshot().bodies) EXPECT_EQ(seen.epoch, 0U);
	EXPECT_EQ(mirror->admit(&body), slot);
	world.step(0.01);
	EXPECT_EQ(world.taken[slot], 0);  // impulses of the previous body do not count for the next one
	hand.tick(2);
	EXPECT_GT(mirror->snapshot().bodies[slot].epoch, epoch);
	world.step(0.01);
	EXPECT_EQ(world.taken[slot], 2);
}

// Both threads run at their own rate with bodies that come and go, without lock or allocation. In the end the sums are equal to the last
// bit.
TEST(WorldMirror, NothingIsLostBetweenTwoThreads)
{
	auto mirror = std::make_unique<WorldMirror>();
	GivingHand hand(*mirror);
	TakingWorld world(*mirror);
	int bodies[40] = {};
	const long before = allocationCount();
	std::atomic<bool> done{false};
	std::atomic<int> ticks{0};
	std::thread ticking([&] {
		while (!done) hand.tick(1 + ticks++ % 3);
	});
	std::minstd_rand random(7);
	for (int step = 0; step < 400; ++step)
	{
		// There are zero to three ticks between two steps.
		for (const int seen = ticks; ticks - seen < step % 4;) std::this_thread::yield();
		for (int slot = 0; slot < kMirroredBodies; ++slot)
			if (random() % 8 == 0 && mirror->body(slot).epoch != 0) mirror->leave(slot);
		int* body = &bodies[random() % 40];
		if (mirror->find(body) < 0) mirror->admit(body);
		world.step(0.01);
	}
	done = true;
	ticking.join();
	// Starting the thread takes an allocation or two.
	EXPECT_LE(allocationCount() - before, 4);
	world.step(0.01);
	double given = 0;
	for (int slot = 0; slot < kMirroredBodies; ++slot)
	{
		EXPECT_EQ(world.taken[slot], hand.given[slot]) << slot;
		given += hand.given[slot];
	}
	EXPECT_GT(given, 0);
}

TEST(ModelAge, FadesFromFiveToTwentyMillisecondsBeyondThePeriod)
{
	ModelAge age;
	EXPECT_EQ(age.factor(5 * kMs), 0);
	age.arrived(1000 * kMs, 16 * kMs);
	EXPECT_EQ(age.factor(1016 * kMs), 1);
	EXPECT_EQ(age.factor(1021 * kMs), 1);
	EXPECT_NEAR(age.factor(1026 * kMs), 10 / 15.0, 1e-12);
	EXPECT_EQ(age.factor(1036 * kMs), 0);
	EXPECT_EQ(age.overdue(1026 * kMs), 10 * kMs);
}

TEST(ModelAge, LearnsASlowWorldAndForgivesOneStall)
{
	ModelAge age;
	std::int64_t now = 0;
	for (int i = 0; i < 6; ++i) age.arrived(now += 33 * kMs, 16 * kMs);
	EXPECT_EQ(age.period(), 33 * kMs);
	age.arrived(now += 500 * kMs, 16 * kMs);
	EXPECT_EQ(age.period(), 33 * kMs);
	for (int i = 0; i < 6; ++i) age.arrived(now += 10 * kMs, 16 * kMs);
	EXPECT_EQ(age.period(), 16 * kMs);
}

// Two bodies that are rotated and shifted together keep their contact; a shift of A against B changes the wrench by K times the shift.
TEST(LinearContact, KnowsOnlyTheWayOfOneBodyAgainstTheOther)
{
	std::mt19937_64 random(5);
	std::uniform_real_distribution<double> u(-1, 1);
	for (int i = 0; i < 20; ++i)
	{
		const auto pose = [&](double turn) {
			return ist::Pose{rotationMatrix(ist::quaternionFromRotationVector(Vec3{turn * u(random), turn * u(random), turn * u(random)})),
				{u(random), i == 0 ? 1000 : u(random), u(random)}};
		};
		LinearContact c;
		c.X_WA = pose(2);
		c.X_WB = pose(2);
		c.point = c.X_WA.translation + Vec3{0.01 * u(random), 0.01 * u(random), 0};
		c.wrench = {{u(random), 2, 3}, {4, 5, u(random)}};
		for (int row = 0; row < 3; ++row) c.stiffness(row, row) = 1000 * (row + 1);
		ist::Pose together;
		together.translation = {u(random), u(random), u(random)};
		double way = 1;
		const LinearContact moved = movedTo(c, together * c.X_WA, together * c.X_WB, &way);
		EXPECT_LT(norm(moved.wrench.force - c.wrench.force) + norm(moved.wrench.torque - c.wrench.torque), 1e-7);
		EXPECT_LT(distance(moved.point, together * c.point) + way, 1e-9);
		ist::Pose shifted = c.X_WA;
		const Vec3 shift{1e-3 * u(random), 1e-3 * u(random), 1e-3 * u(random)};
		shifted.translation += shift;
		const LinearContact pushed = movedTo(c, shifted, c.X_WB, &way);
		EXPECT_LT(norm(pushed.wrench.force - c.wrench.force + Vec3{1000 * shift.x, 2000 * shift.y, 3000 * shift.z}), 1e-7);
		EXPECT_NEAR(way, norm(shift), 1e-9);
	}
}
