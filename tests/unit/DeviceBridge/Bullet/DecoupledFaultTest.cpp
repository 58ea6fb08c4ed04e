// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/DeviceBridge/Bullet/DecoupledRig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

using namespace devicebridge;
using ist::Vec3;

namespace
{
const Vec3 kGravity{0, -9.81, 0};
/// A simulated hand on a simulated device presses a box on a table. The world steps between the ticks, in virtual time.
struct PressedRig
{
	DecoupledRig rig;
	btRigidBody* box;
	SimulatedDevice device{simulatedProfile("sigma7").value()};
	btRigidBody tool{Hand::info(rig.ballShape, {0, 0.065, 0})};
	BulletDecoupledSource source;
	SteppingThread thread;
	double steepest = 0;  ///< largest rise of the force from one tick to the next [N]

	double largest = 0;  ///< largest force [N]

	explicit PressedRig(double rate, ContactThreading topology = ContactThreading::InHapticThread, double mass = 0.3,
		std::int64_t maxPairs = -1, const std::shared_ptr<const ist::InnerSphereTree>& tree = ballTree())
		: rig(rate, kGravity),
		  box((rig.addPlane(), rig.addBox(mass, {0, 0.02, 0}))),
		  source(tool, tree, rig.clock, settings(topology, maxPairs)),
		  thread(device, source, rig.clock)
	{
		if (const auto refused = rig.world.materials().set(&tool, {2e7, -1})) throw std::runtime_error(refused->message);
		rig.coupling.add(source);
		ist::Pose start;
		start.translation = {0, 0.065, 0};
		ist::Pose pressed;
		pressed.translation = {0, 0.051, 0};
		device.place(start);
		device.setHand(handThrough({{0.6, start}, {0.9, pressed}}));
		device.open();
		rig.coupling.show(rig.period);
	}
	static BulletDecoupledSettings settings(ContactThreading topology, std::int64_t maxPairs)
	{
		BulletDecoupledSettings s = handSettings();
		s.maxPairs = maxPairs;
		s.gains = {2000, 0.4, 0, 0, 12, 0.2};
		s.topology = topology;
		return s;
	}
	double force() const { return norm(device.lastCommand().wrench.force); }
	void run(int ticks)
	{
		for (int i = 0; i < ticks; ++i)
		{
			while (rig.worldRuns && static_cast<double>(rig.worldSteps + 1) * rig.period <= rig.time() + 1e-9) rig.stepWorld();
			const double before = force();
			thread.run(1);
			source.serveContacts();
			steepest = std::max(steepest, force() - before);
			largest = std::max(largest, force());
		}
	}
	/// The world has missed steps and does not catch up.
	void resume()
	{
		rig.worldSteps = static_cast<std::int64_t>(rig.time() / rig.period);
		rig.worldRuns = true;
	}
};
}  // namespace

TEST(DecoupledFault, AWorldThatStallsTakesItsForceWithItAndGivesItBackWithoutAJump)
{
	for (const double rate : {60.0, 240.0})
		for (const ContactThreading topology : kTopologies)
		{
			PressedRig r(rate, topology);
			r.run(1500);
			const double pressing = r.force(), depth = double(r.box->getWorldTransform().getOrigin().y());
			ASSERT_GT(pressing, 1.5) << nameOf(topology);
			r.rig.worldRuns = false;
			// Time until zero force: up to one period until a step is missed, 20 ms after that, and one tick.
			r.run(static_cast<int>(std::ceil(1000 / rate)) + 21);
			for (int i = 0; i < 100 - 21 - static_cast<int>(std::ceil(1000 / rate)); ++i)
			{
				EXPECT_EQ(r.force(), 0) << nameOf(topology) << " at " << rate << ", tick " << i;
				r.run(1);
			}
			EXPECT_LT(norm(r.source.undelivered()), 2 * pressing * (r.rig.period + 0.02));
			r.steepest = r.largest = 0;
			r.resume();
			r.run(2000);
			EXPECT_NEAR(r.force(), pressing, 0.15 * pressing) << nameOf(topology) << " at " << rate;
			// The limiter alone permits a rise of 12 N in 20 ms. When the hand is pushed out of the body that it has sunk into, the
			// passivity controller reduces the force.
			EXPECT_LT(r.steepest, 0.4) << nameOf(topology) << " at " << rate;
			EXPECT_LT(r.largest, 1.3 * pressing) << nameOf(topology) << " at " << rate;
			EXPECT_NEAR(double(r.box->getWorldTransform().getOrigin().y()), depth, 1e-3);
			EXPECT_FALSE(r.thread.faulted());
			std::printf("%s, %g Hz: %.2f N before, %.2f N after, steepest rise %.3f N in a tick\n", nameOf(topology), rate, pressing,
				r.force(), r.steepest);
		}
}

TEST(DecoupledFault, AWorldThatDiesLeavesAFreeHand)
{
	PressedRig r(60);
	r.run(1500);
	r.rig.worldRuns = false;
	r.run(2000);
	EXPECT_EQ(r.force(), 0);
	EXPECT_EQ(r.thread.ticks(), 3500U);
	EXPECT_GT(r.source.statistics().fadedTicks, 1900U);
	EXPECT_GT(r.source.statistics().longestModelAge, 1.9);
	// The hand moves freely, and the tool follows it.
	EXPECT_NEAR(r.source.toolState().X_WT.translation.y, 0.051, 1e-3);
	EXPECT_LT(norm(r.source.undelivered()), 0.2);
}

TEST(DecoupledFault, TopologiesFeelAlikeAndSwitchWhileRunning)
{
	double felt[3] = {};
	for (int i = 0; i < 3; ++i)
	{
		PressedRig r(240, kTopologies[i]);
		r.run(2000);
		felt[i] = r.force();
	}
	EXPECT_NEAR(felt[1], felt[0], 0.03 * felt[0]);
	EXPECT_NEAR(felt[2], felt[0], 0.03 * felt[0]);

	PressedRig r(240);
	r.run(2000);
	r.steepest = 0;
	for (int i = 0; i < 12; ++i)
	{
		r.source.setTopology(kTopologies[i % 3]);
		r.run(150);
		EXPECT_GT(r.force(), 0.8 * felt[0]) << nameOf(kTopologies[i % 3]);
	}
	EXPECT_LT(r.steepest, 0.3);
	std::printf("%.3f N in the tick, %.3f N in its own thread, %.3f N in the world; steepest %.3f N at a switch\n", felt[0], felt[1],
		felt[2], r.steepest);
}

TEST(DecoupledFault, RunsInVirtualTimeAreAlikeToTheLastBit)
{
	for (const ContactThreading topology : kTopologies)
	{
		std::vector<double> traces[2];
		for (std::vector<double>& trace : traces)
		{
			PressedRig r(60, topology, 0.01);
			for (int i = 0; i < 1200; ++i)
			{
				r.run(1);
				trace.push_back(r.force());
				trace.push_back(r.device.truePose().translation.y);
				trace.push_back(double(r.box->getWorldTransform().getOrigin().y()));
			}
		}
		EXPECT_EQ(std::memcmp(traces[0].data(), traces[1].data(), traces[0].size() * sizeof(double)), 0) << nameOf(topology);
	}
}

TEST(DecoupledFault, ATickDoesNotAllocate)
{
	for (const ContactThreading topology : kTopologies)
	{
		PressedRig r(60, topology);
		r.run(1500);
		long inTicks = 0;
		for (int i = 0; i < 300; ++i)
		{
			while (static_cast<double>(r.rig.worldSteps + 1) * r.rig.period <= r.rig.time() + 1e-9) r.rig.stepWorld();
			const long before = allocationCount();
			r.thread.run(1);
			r.source.serveContacts();
			inTicks += allocationCount() - before;
		}
		EXPECT_EQ(inTicks, 0) << nameOf(topology);
		EXPECT_GT(r.thread.step().contactCount, 0);
	}
}

// No tick allocates from the first on: a tool with few leaves approaches a plane and a body with many, which is then replaced.
TEST(DecoupledFault, ATickDoesNotAllocateAtTheFirstMeetingWithALargerTree)
{
	auto coarse = std::make_shared<ist::InnerSphereTree>(*ballTree());
	coarse->law = coarse->levels.back();
	coarse->levels.clear();
	for (const ContactThreading topology : kTopologies)
		for (const std::int64_t maxPairs : {-1, 20})
		{
			PressedRig r(60, topology, 0.3, maxPairs, coarse);
			ASSERT_GT(std::min(mostSlots(*ballTree()), mostSlots(*boxTree())), 2 * mostSlots(*coarse));
			long inTicks = 0;
			const auto run = [&](int ticks) {
				for (int i = 0; i < ticks; ++i)
				{
					while (static_cast<double>(r.rig.worldSteps + 1) * r.rig.period <= r.rig.time() + 1e-9) r.rig.stepWorld();
					const long before = allocationCount();
					r.thread.run(1);
					r.source.serveContacts();
					inTicks += allocationCount() - before;
				}
			};
			run(1500);
			EXPECT_GT(r.thread.step().contactCount, 0) << nameOf(topology);
			r.box->setCollisionShape(&r.rig.ballShape);
			run(1500);
			EXPECT_GT(r.thread.step().contactCount, 0) << nameOf(topology);
			EXPECT_EQ(inTicks, 0) << nameOf(topology) << ", " << maxPairs;
			EXPECT_EQ(r.source.statistics().refusedQueries, 0U);
		}
}

TEST(DecoupledFault, ABodyThatIsTakenAwayIsForgotten)
{
	PressedRig r(60);
	r.run(1500);
	ASSERT_GT(r.force(), 1.5);
	r.rig.coupling.forget(r.box);
	r.rig.world.bullet().removeRigidBody(r.box);
	r.run(300);
	EXPECT_LT(r.force(), 0.05);  // the remaining force is the tool's inertia
	EXPECT_EQ(r.thread.step().contactCount, 0);
	r.rig.world.bullet().addRigidBody(r.box);
	r.run(1500);
	EXPECT_GT(r.force(), 1.5);
}

TEST(DecoupledFault, ABodyThatIsTakenAwayWithinAStepIsNotTouchedAfterIt)
{
	PressedRig r(60);
	r.run(1500);
	ASSERT_GT(r.force(), 1.5);
	r.rig.coupling.beforeStep(r.rig.period);
	r.rig.world.bullet().stepSimulation(btScalar(r.rig.period), 0);
	r.rig.coupling.forget(r.box);
	r.rig.world.bullet().removeRigidBody(r.box);
	// With this velocity, afterStep() would move the body if it still knew it.
	r.box->setLinearVelocity(btVector3(0, -1, 0));
	const btVector3 left = r.box->getWorldTransform().getOrigin();
	r.rig.coupling.afterStep();
	EXPECT_EQ(r.box->getWorldTransform().getOrigin(), left);
	r.box->setLinearVelocity(btVector3(0, 0, 0));
	r.rig.world.bullet().addRigidBody(r.box);
	r.run(1500);
	EXPECT_GT(r.force(), 1.5);
}

// Each change removes the tree from a body that is pressed, and then restores it.
TEST(DecoupledFault, ABodyWhoseTreeDoesNotSpeakForItAnyMoreIsNotFelt)
{
	btConvexHullShape stock;
	for (int i = 0; i < 8; ++i) stock.addPoint(bullet(kBoxHalf * ist::Vec3{i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0}));
	using Change = std::function<void(PressedRig&)>;
	const std::pair<Change, Change> changes[] = {
		{[&](PressedRig& r) { r.box->setCollisionShape(&stock); }, [](PressedRig& r) { r.box->setCollisionShape(&r.rig.boxShape); }},
		{[](PressedRig& r) { r.rig.boxShape.setLocalScaling(btVector3(1, 1, btScalar(1.1))); },
			[](PressedRig& r) { r.rig.boxShape.setLocalScaling(btVector3(1, 1, 1)); }},
		{[](PressedRig& r) { r.box->setCollisionFlags(r.box->getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE); },
			[](PressedRig& r) { r.box->setCollisionFlags(r.box->getCollisionFlags() & ~btCollisionObject::CF_NO_CONTACT_RESPONSE); }}};
	int which = 0;
	for (const auto& [take, giveBack] : changes)
	{
		++which;
		PressedRig r(60);
		r.run(1500);
		ASSERT_GT(r.force(), 1.5);
		const btTransform before = r.box->getWorldTransform();
		take(r);
		r.run(18);
		for (int i = 0; i < 100; ++i)
		{
			r.run(1);
			ASSERT_EQ(r.thread.step().contactCount, 0) << which << ", tick " << i;
		}
		giveBack(r);
		r.box->setWorldTransform(before);  // the body may have fallen
		r.box->setLinearVelocity(btVector3(0, 0, 0));
		r.box->setAngularVelocity(btVector3(0, 0, 0));
		r.run(2000);
		EXPECT_GT(r.force(), 1.5) << which;
	}
}

// A box without a tree is felt in closed form, as in the world.
TEST(DecoupledFault, ABoxThatLosesItsTreeIsFeltInClosedForm)
{
	PressedRig r(60, ContactThreading::InHapticThread, 0);
	r.run(1500);
	const double pressing = r.force();
	ASSERT_GT(pressing, 1.5);
	r.rig.boxTreeAttached.detach();
	r.run(2000);
	EXPECT_NEAR(r.force(), pressing, 0.05 * pressing);
	r.rig.boxTreeAttached = std::move(r.rig.world.attach(&r.rig.boxShape, boxTree())).value();
	r.run(2000);
	EXPECT_NEAR(r.force(), pressing, 0.05 * pressing);
}

TEST(DecoupledFault, ABodyWithAnotherShapeIsFeltAsThat)
{
	btConvexHullShape stock;
	for (const double x : {-1.0, 1.0})
		for (const double y : {-0.01, 0.01})
			for (const double z : {-1.0, 1.0}) stock.addPoint(bullet({x, y, z}));
	DecoupledRig rig(60);
	btRigidBody* body = rig.addPlane();
	Hand& hand = rig.addHand({0, 0.025, 0});
	hand.script = [](double t) { return ist::Twist{{0, t < 0.2 ? -0.05 : 0, 0}, {}}; };
	const auto pair = [&]() -> const MirroredPair* {
		const WorldSnapshot& world = hand.source.mirror().snapshot();
		return world.pairCount > 0 ? &world.pairs[0] : nullptr;
	};
	const auto isPlane = [&] { return pair() && !pair()->tree && std::holds_alternative<ist::HalfSpaceField>(pair()->field); };
	rig.run(0.5);
	ASSERT_TRUE(isPlane());
	EXPECT_GT(hand.step.contactCount, 0);
	body->setCollisionShape(&stock);
	rig.afterWorldStep = [&, steps = 0]() mutable {
		if (steps++ > 0) return;
		hand.source.mirror().fetch();
		EXPECT_FALSE(pair());  // the shape is no plane any more
		EXPECT_TRUE(hand.source.mirror().snapshot().bodies[0].leaving);
	};
	rig.run(0.2);
	EXPECT_EQ(hand.source.mirror().snapshot().bodies[0].epoch, 0U);
	EXPECT_EQ(hand.step.contactCount, 0);
	body->setCollisionShape(&rig.ballShape);
	rig.run(0.2);
	ASSERT_TRUE(pair());
	EXPECT_EQ(pair()->tree, rig.world.registration().registry().find(&rig.ballShape).get());
	EXPECT_GT(hand.step.contactCount, 0);
	body->setCollisionShape(&rig.planeShape);
	rig.run(0.2);
	ASSERT_TRUE(isPlane());
}

TEST(DecoupledFault, AHandThatIsRemovedLetsGoAndFeelsAgainWhenItIsAdded)
{
	for (const ContactThreading topology : kTopologies)
	{
		PressedRig r(60, topology);
		r.run(1500);
		const double pressing = r.force();
		ASSERT_GT(pressing, 1.5) << nameOf(topology);
		r.rig.coupling.remove(r.source);
		for (int i = 0; i < 300; ++i)
		{
			r.run(1);
			ASSERT_EQ(r.thread.step().contactCount, 0) << nameOf(topology) << ", tick " << i;
		}
		r.rig.coupling.add(r.source);
		r.run(2000);
		EXPECT_NEAR(r.force(), pressing, 0.15 * pressing) << nameOf(topology);
		// The table carries the weight plus the force of the hand.
		const Vec3 before = r.rig.coupling.appliedImpulse(r.source);
		r.run(1000);
		EXPECT_NEAR(before.y - r.rig.coupling.appliedImpulse(r.source).y, pressing, 0.2 * pressing) << nameOf(topology);
	}
}

TEST(DecoupledFault, ATreeGoesWithTheHandThatIsRemoved)
{
	for (const ContactThreading topology : kTopologies)
		for (const bool destroyed : {false, true})
		{
			PressedRig r(60, topology);
			btBoxShape shape(r.rig.boxShape);
			std::shared_ptr<const ist::InnerSphereTree> tree(
				new ist::InnerSphereTree(*boxTree()));  // separate memory, which is freed with the tree
			const std::weak_ptr<const ist::InnerSphereTree> kept = tree;
			auto attached = std::move(r.rig.world.attach(&shape, std::move(tree))).value();
			r.box->setCollisionShape(&shape);
			r.rig.coupling.remove(r.source);
			auto coupling = std::make_unique<BulletWorldCoupling>(r.rig.world);
			coupling->add(r.source);
			coupling->show(r.rig.period);
			const auto run = [&](int ticks) {
				for (int i = 0; i < ticks; ++i)
				{
					if (coupling && i % 10 == 0) coupling->step(0.01);
					r.thread.run(1);
					if (i + 1 < ticks) r.source.serveContacts();  // the last question stays open
				}
			};
			run(1500);
			ASSERT_GT(r.force(), 1.5) << nameOf(topology);
			if (destroyed) coupling = nullptr;
			else coupling->remove(r.source);
			r.box->setCollisionShape(&r.rig.boxShape);
			attached.detach();
			EXPECT_EQ(kept.expired(), !destroyed) << nameOf(topology);
			r.source.serveContacts();
			run(100);
			EXPECT_EQ(r.force(), 0) << nameOf(topology) << destroyed;
			// In the next world, too, only the bodies that it shows are felt.
			r.rig.coupling.add(r.source);
			r.rig.worldSteps = static_cast<std::int64_t>(r.rig.time() / r.rig.period);
			r.run(2000);
			EXPECT_TRUE(kept.expired()) << nameOf(topology);
			EXPECT_GT(r.force(), 1.5) << nameOf(topology);
		}
}

TEST(DecoupledFault, ABodyThatIsNotFiniteIsLetGo)
{
	for (const bool velocity : {true, false})
	{
		PressedRig r(60);
		r.run(1500);
		ASSERT_GT(r.force(), 1.5);
		const btTransform good = r.box->getWorldTransform();
		const btVector3 nan(btScalar(std::nan("")), 0, 0);
		if (velocity) r.box->setLinearVelocity(nan);
		else r.box->setWorldTransform(btTransform(btQuaternion::getIdentity(), nan));
		r.rig.worldRuns = false;  // Bullet itself does not step such a body
		r.rig.coupling.beforeStep(r.rig.period);
		r.rig.coupling.afterStep();
		for (int i = 0; i < 300; ++i)
		{
			r.run(1);
			ASSERT_TRUE(std::isfinite(r.force()) && isRigid(r.source.toolState().X_WT) && isFinite(r.source.toolState().twist)) << i;
		}
		EXPECT_FALSE(r.thread.faulted());
		EXPECT_EQ(r.force(), 0);
		r.box->setLinearVelocity(btVector3(0, 0, 0));
		r.box->setWorldTransform(good);
		r.resume();
		r.run(1500);
		EXPECT_GT(r.force(), 1.5);
	}
}

// World, hand and contact each run in their own thread on a real clock. No thread waits for another, and in the end the momentum balances.
TEST(DecoupledFault, ThreeThreadsLoseNothing)
{
	DecoupledRig rig(200);
	btRigidBody* box = rig.addBox(0.2, {0.046, 0, 0});
	RealClock clock;
	btRigidBody tool(Hand::info(rig.ballShape, {}));
	BulletDecoupledSettings settings = handSettings();
	settings.topology = ContactThreading::OwnThread;
	BulletDecoupledSource source(tool, ballTree(), clock, settings);
	rig.coupling.add(source);
	rig.coupling.show(rig.period);
	SimulatedDevice device(simulatedProfile("sigma7").value());
	device.setHand([](double t) { return HandTarget{{{}, {std::min(0.08 * t, 0.06), 0, 0}}, {}}; });
	device.open();
	SteppingThread thread(device, source, clock);
	std::atomic<bool> running{true};
	std::thread world([&] {
		for (std::int64_t next = clock.now(); running; clock.sleepUntil(next += 5'000'000)) rig.coupling.step(rig.period);
	});
	ASSERT_TRUE(source.startContactThread());
	EXPECT_FALSE(source.startContactThread());
	ASSERT_TRUE(thread.start());
	const std::int64_t end = clock.now() + 10'000'000'000;
	// The loop runs until the tool has met the body and some time more, on any machine.
	while (clock.now() < end && thread.ticks() < 900) clock.sleepUntil(clock.now() + 20'000'000);
	thread.stop();
	source.stopContactThread();
	running = false;
	world.join();
	rig.coupling.step(rig.period);
	const Vec3 given = -source.receivedImpulse(), applied = rig.coupling.appliedImpulse(source);
	const Vec3 momentum = 0.2 * vec3(box->getLinearVelocity());
	EXPECT_LT(norm(given - applied), 1e-12 + 1e-9 * norm(given));
	EXPECT_LT(norm(momentum - applied), 1e-5);
	const DecoupledStatistics s = source.statistics();
	EXPECT_GT(s.worldSteps, 0U);
	EXPECT_GT(s.modelAnswers, 0U);
	std::printf("given %.4f N s; %llu ticks, %llu steps, %llu answers, %llu faded ticks; tick p50 %.0f us, p99 %.0f us; %s\n", norm(given),
		static_cast<unsigned long long>(thread.ticks()), static_cast<unsigned long long>(s.worldSteps),
		static_cast<unsigned long long>(s.modelAnswers), static_cast<unsigned long long>(s.fadedTicks), thread.costs().quantile(0.5) / 1e3,
		thread.costs().quantile(0.99) / 1e3, thread.scheduling());
}
