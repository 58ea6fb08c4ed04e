// SPDX-License-Identifier: Zlib
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/DeviceBridge/Bullet/DecoupledRig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

using namespace devicebridge;
using ist::Vec3;

namespace
{
const Vec3 kGravity{0, -9.81, 0};

/// Balance of the momentum of everything, measured from outside. For tools it excludes the impulses of their couplings. For Bullet's bodies
/// it excludes those of gravity and table.
struct Books
{
	DecoupledRig& rig;
	Vec3 gravity;
	Vec3 fromOthers;  // impulse of gravity and table on the bodies [N s]
	struct Entry
	{
		Vec3 onTools, onWorld, ledger;
	};
	std::vector<Entry> atSteps;
	double largestLedger = 0;
	std::int64_t seenSteps = 0;

	explicit Books(DecoupledRig& r, const Vec3& g = {}) : rig(r), gravity(g)
	{
		rig.afterWorldStep = [this] { stepped(); };
		rig.afterTick = [this] { ticked(); };
	}
	void stepped()
	{
		for (const auto& body : rig.bodies)
			if (body->getInvMass() > 0) fromOthers += gravity * (rig.period / double(body->getInvMass()));
		const btISTContactStore& store = rig.world.contacts();
		for (const btISTContact* c : store.contacts())
		{
			if (c->stamp + 1 != store.step()) continue;
			const bool fixedA = c->bodyA->isStaticObject(), fixedB = c->bodyB->isStaticObject();
			for (int i = 0; i < c->patchCount && fixedA != fixedB; ++i) fromOthers += c->impulses[i].force * (fixedB ? 1.0 : -1.0);
		}
	}
	/// Records an entry in the first tick that has received a step of the world.
	void ticked()
	{
		Entry now;
		for (const auto& hand : rig.hands)
		{
			now.onTools += hand->momentum() - hand->coupled;
			now.ledger += hand->source.undelivered();
		}
		for (const auto& body : rig.bodies)
			if (body->getInvMass() > 0) now.onWorld += vec3(body->getLinearVelocity()) / double(body->getInvMass());
		now.onWorld -= fromOthers;
		largestLedger = std::max(largestLedger, norm(now.ledger));
		if (rig.worldSteps == seenSteps) return;
		seenSteps = rig.worldSteps;
		atSteps.push_back(now);
	}
	/// Checks all windows of five steps and of fifty.
	void audit(double floor, const std::string& name) const
	{
		double worst = 0, largestStep = 0;
		for (std::size_t i = 1; i < atSteps.size(); ++i)
			largestStep = std::max(largestStep, norm(atSteps[i].onTools - atSteps[i - 1].onTools));
		for (const std::size_t length : {5, 50})
			for (std::size_t i = length; i < atSteps.size(); ++i)
			{
				const Entry &end = atSteps[i], &begin = atSteps[i - length];
				const Vec3 tools = end.onTools - begin.onTools, world = end.onWorld - begin.onWorld, ledger = end.ledger - begin.ledger;
				const double larger = std::max(norm(tools), norm(world)), rest = norm(tools + world + ledger);
				ASSERT_LE(rest, 1e-3 * larger + floor) << name << ", steps " << i - length << " to " << i;
				if (larger > 1e3 * floor) worst = std::max(worst, rest / larger);
			}
		EXPECT_GT(largestStep, 100 * floor) << name;
		// Two tools may each have an impulse of a step under way, and surfaces begin to press at once.
		EXPECT_LE(largestLedger, 3 * largestStep) << name;
		std::printf("%s: %zu steps, worst window %.1e of the larger impulse, ledger at most %.2f of a step's\n", name.c_str(),
			atSteps.size(), worst, largestLedger / largestStep);
	}
};

std::string named(const char* scene, double rate, double mass)
{
	char text[80];
	std::snprintf(text, sizeof text, "%s, world at %g Hz, bodies of %g kg", scene, rate, mass);
	return text;
}

template <class Test> void forWorlds(Test test)
{
	for (const double rate : {5.0, 60.0, 240.0})
		for (const double mass : {0.3, 0.001}) test(rate, mass);
}

double fastest(const DecoupledRig& rig)
{
	double speed = 0;
	for (const auto& body : rig.bodies) speed = std::max(speed, norm(vec3(body->getLinearVelocity())));
	return speed;
}

/// Oscillation along x, at a speed of up to `amplitude` times `omega`.
std::function<ist::Twist(double)> shaking(double amplitude, double omega)
{
	return [=](double t) {
		return ist::Twist{{amplitude * omega * std::cos(omega * t), 0.1 * amplitude * omega * std::sin(1.7 * omega * t), 0}, {0.3, 0, 0.2}};
	};
}

/// Motion down by `depth` within 0.2 s, starting at t = 0.5 s.
std::function<ist::Twist(double)> pressing(double depth)
{
	return [=](double t) { return ist::Twist{{0, t > 0.5 && t <= 0.7 ? -depth / 0.2 : 0, 0}, {}}; };
}
}  // namespace

TEST(BulletDecoupled, ImpulsesBalanceWithTheToolBetweenTwoBodies)
{
	forWorlds([](double rate, double mass) {
		DecoupledRig rig(rate);
		rig.addBall(mass, {0.045, 0.003, 0});
		rig.addBox(mass, {-0.046, 0, 0.002});
		rig.addHand({}).script = shaking(0.03, 8);
		Books books(rig);
		rig.run(std::max(1.5, 52 / rate));
		books.audit(1e-7 * mass, named("between two bodies", rate, mass));
		// The contact is elastic at most, so no body leaves the tool at more than twice the tool's speed.
		EXPECT_LT(fastest(rig), 2 * 0.25 + 0.1) << named("", rate, mass);
	});
}

TEST(BulletDecoupled, ImpulsesBalanceWithTwoToolsOnOneBody)
{
	forWorlds([](double rate, double mass) {
		DecoupledRig rig(rate);
		rig.addBox(mass, {0, 0, 0});
		rig.addHand({-0.045, 0.002, 0}).script = shaking(0.02, 7);
		rig.addHand({0.045, 0, 0.003}).script = shaking(0.02, 9);
		Books books(rig);
		rig.run(std::max(1.5, 52 / rate));
		books.audit(1e-7 * mass, named("two tools", rate, mass));
		// A body thrown from one tool to the other gains at most twice the speed of each. At 5 Hz each of them learns 0.2 s later what the
		// other did, and together they throw a gram from one to the other ever faster: in 10 of 24 places by up to 8 m/s.
		const double most = rate > 10 || mass > 0.01 ? 2 * 0.14 + 2 * 0.18 + 0.1 : 10;
		EXPECT_LT(fastest(rig), most) << named("", rate, mass);
	});
}

// The table is so slippery that the stack slides and does not topple. At 5 Hz, in steps of 10 mm, there is a single box. There is no third
// box, because the bumps of 300 spheres would make it lean.
TEST(BulletDecoupled, ImpulsesBalanceWhileAStackIsPushed)
{
	forWorlds([](double rate, double mass) {
		DecoupledRig rig(rate, kGravity);
		const double stiffness = mass > 0.01 ? 2e7 : 2e5;
		rig.add(rig.planeShape, 0, {}, 0.2);
		const int count = rate < 10 ? 1 : 2;
		for (int i = 0; i < count; ++i) rig.add(rig.boxShape, mass, {0, 0.02 + 0.0399 * i, 0}, 0.8, stiffness);
		Hand& hand = rig.addHand({-0.06, 0.022, 0});
		hand.script = [](double t) { return ist::Twist{{t > 1 && t < 3 ? 0.05 : 0, 0, 0}, {}}; };
		Books books(rig, kGravity);
		rig.run(4);
		books.audit(2e-6 * mass * 9.81, named("stack", rate, mass));
		for (int i = 1; i <= count; ++i)
		{
			const Vec3 at = vec3(rig.bodies[static_cast<std::size_t>(i)]->getWorldTransform().getOrigin());
			// In a step at 60 Hz the tool gives two grams more than their weight does. They hop, and the upper one may slide off the other.
			const bool hops = rate > 10 && rate < 100 && mass < 0.01;
			EXPECT_NEAR(at.x, 0.08, rate < 10 ? 0.03 : hops ? 0.1 : mass < 0.01 ? 0.025 : 0.012) << i << named("", rate, mass);
			const double lowest = hops ? 0.02 : 0.04 * i - 0.02;
			EXPECT_GT(at.y, lowest - 0.003) << i << named("", rate, mass);
			EXPECT_LT(at.y, 0.04 * i - 0.02 + 0.003) << i << named("", rate, mass);
		}
		EXPECT_LT(hand.largest, 3) << named("", rate, mass);
	});
}

TEST(BulletDecoupled, ALiftedBodyWeighsOnTheHand)
{
	forWorlds([](double rate, double mass) {
		DecoupledRig rig(rate, kGravity);
		const double stiffness = mass > 0.01 ? 2e7 : 2e5;
		btRigidBody* box = rig.add(rig.boxShape, mass, {0, 0.0403, 0}, 0.8, stiffness);
		Hand& hand = rig.addHand({}, handSettings(), true);
		hand.script = [](double t) { return ist::Twist{{0, t > 1 && t < 2 ? 0.05 : 0, 0}, {}}; };
		Books books(rig, kGravity);
		rig.run(3);
		Vec3 sum;
		const auto balance = rig.afterTick;
		rig.afterTick = [&] { balance(), sum += hand.step.coupling.force; };
		rig.run(1);
		books.audit(2e-6 * mass * 9.81, named("lift", rate, mass));
		const double height = double(box->getWorldTransform().getOrigin().y());
		EXPECT_NEAR(sum.y / 1000, mass * 9.81, 0.02 * mass * 9.81) << named("", rate, mass);
		// The hand's spring yields by the weight over its stiffness. The bodies yield by less than 1 mm and lie within their gaps.
		EXPECT_NEAR(height, 0.09 - mass * 9.81 / 1000, 0.002) << named("", rate, mass);
	});
}

// The support has no tree, so Bullet's own points carry the body. The hand does not push the body through the support.
TEST(BulletDecoupled, ABodyOnAStockShapeIsPressed)
{
	for (const double rate : {60.0, 240.0})
	{
		btBoxShape support(btVector3(btScalar(0.2), btScalar(0.1), btScalar(0.2)));
		DecoupledRig rig(rate, kGravity);
		rig.add(support, 0, {0, -0.1, 0});
		btRigidBody* box = rig.addBox(0.1, {0, 0.02, 0});
		Hand& hand = rig.addHand({0, 0.065, 0});
		hand.script = pressing(0.008);
		rig.run(1.5);
		const double height = double(box->getWorldTransform().getOrigin().y());
		double least = 1e9, most = 0;
		rig.afterTick = [&] {
			const double force = norm(hand.step.coupling.force);
			least = std::min(least, force);
			most = std::max(most, force);
		};
		rig.run(1);
		std::printf("stock support, world at %g Hz: %.3f to %.3f N, box at %.5f m\n", rate, least, most, height);
		EXPECT_NEAR(height, 0.02, 1e-3) << rate;
		EXPECT_GT(least, 1) << rate;
		EXPECT_LT(most, 1.2 * least) << rate;
	}
}

// A body that the hand accelerates is where it would be in a world that steps in every tick, and feels equally heavy.
TEST(BulletDecoupled, AFreeBodyIsPushedAlikeAtAnyRate)
{
	for (const double mass : {0.3, 0.03})
	{
		double largest[3] = {}, travelled[3] = {};
		int i = 0;
		for (const double rate : {1000.0, 60.0, 5.0})
		{
			DecoupledRig rig(rate);
			btRigidBody* box = rig.addBox(mass, {0.0405, 0, 0});
			Hand& hand = rig.addHand({});
			hand.script = [](double t) { return ist::Twist{{t > 0.1 ? std::min(0.4, t - 0.1) : 0, 0, 0}, {}}; };
			rig.run(0.6);
			largest[i] = hand.largest;
			travelled[i++] = double(box->getWorldTransform().getOrigin().x()) - 0.0405;
			// The hand feels F = m a of tool and body, apart from the impact of the first touch.
			EXPECT_GT(hand.largest, mass + kDecoupledToolMass);
			EXPECT_LT(hand.largest, 2.5 * (mass + kDecoupledToolMass));
		}
		EXPECT_NEAR(largest[1], largest[0], 0.05 * largest[0]) << mass;
		EXPECT_NEAR(largest[2], largest[0], 0.05 * largest[0]) << mass;
		EXPECT_NEAR(travelled[1], travelled[0], 0.1 * travelled[0]) << mass;
	}
}

// The table carries the weight and the hand's force: 1.4 N on a body of 1 g, in a world that steps five times a second.
TEST(BulletDecoupled, ABodyOnATableIsPressed)
{
	forWorlds([](double rate, double mass) {
		DecoupledRig rig(rate, kGravity);
		rig.addPlane();
		btRigidBody* box = rig.addBox(mass, {0, 0.02, 0});
		Hand& hand = rig.addHand({0, 0.065, 0});
		hand.script = pressing(0.008);
		rig.run(2);
		Vec3 table, pressed;
		rig.afterWorldStep = [&] {
			for (const btISTContact* c : rig.world.contacts().contacts())
				for (int i = 0; i < c->patchCount; ++i) table += c->impulses[i].force * (c->bodyA == box ? 1.0 : -1.0);
		};
		rig.afterTick = [&] { pressed += 1e-3 * hand.step.coupling.force; };
		rig.run(4);
		const double weight = mass * 9.81;
		EXPECT_GT(-pressed.y / 4, 1) << named("", rate, mass);
		EXPECT_NEAR(table.y / 4, -pressed.y / 4 + weight, 0.01 * (weight - pressed.y / 4)) << named("", rate, mass);
		EXPECT_LT(hand.largest, 2) << named("", rate, mass);
		EXPECT_LT(fastest(rig), 0.02) << named("", rate, mass);
	});
}

// A still hand does no work. So no body may leave with more energy than it came with, at any rate of the world.
TEST(BulletDecoupled, ABodyThatIsThrownAtTheToolBringsNoEnergyBack)
{
	std::mt19937_64 random(11);
	std::uniform_real_distribution<double> u(-1, 1);
	forWorlds([&](double rate, double mass) {
		double most = 0;
		for (int i = 0; i < 4; ++i)
		{
			DecoupledRig rig(rate);
			const Vec3 from = normalized(Vec3{u(random), u(random), u(random)});
			btRigidBody* ball = i % 2 ? rig.addBall(mass, 0.06 * from) : rig.addBox(mass, 0.07 * from);
			const double speed = 0.2;
			ball->setLinearVelocity(bullet(-speed * from));
			Hand& hand = rig.addHand({});
			int touching = 0;
			rig.afterTick = [&] { touching += hand.step.contactCount; };
			rig.run(2);
			const Vec3 v = vec3(ball->getLinearVelocity()), w = vec3(ball->getAngularVelocity());
			const double spin = norm(w) * norm(w) / std::max(1e-30, double(ball->getInvInertiaDiagLocal().x()));
			EXPECT_GT(touching, 0) << named("", rate, mass);
			most = std::max(most, (mass * squaredNorm(v) + spin) / (mass * speed * speed));
		}
		EXPECT_LT(most, 1) << named("", rate, mass);
		std::printf("thrown, world at %g Hz, %g kg: %.2f of the energy comes back\n", rate, mass, most);
	});
}

// Between the steps there are frames in which nothing is simulated. The body receives all impulses of the hand and no others.
TEST(BulletDecoupled, FramesOfNoLengthNeitherPushNorLoseImpulses)
{
	for (const double none : {0.0, -0.01, std::nan(""), HUGE_VAL})
		for (const bool whole : {false, true})
		{
			DecoupledRig rig(60);
			btRigidBody* box = rig.addBox(0.3, {0.0405, 0, 0});
			Hand& hand = rig.addHand({});
			hand.script = [](double t) { return ist::Twist{{t > 0.1 ? std::min(0.4, t - 0.1) : 0, 0, 0}, {}}; };
			const auto frame = [&] {
				if (whole) return rig.coupling.step(none);
				rig.coupling.beforeStep(none);
				rig.world.bullet().stepSimulation(0, 0);
				rig.coupling.afterStep();
			};
			rig.coupling.show(none);
			EXPECT_FALSE(hand.source.mirror().fetch());
			rig.afterTick = [&] {
				if (rig.ticks % 3 == 0) frame();
			};
			rig.run(0.6);
			rig.stepWorld();
			const Vec3 given = -hand.source.receivedImpulse(), momentum = 0.3 * vec3(box->getLinearVelocity());
			EXPECT_GT(given.x, 0.05) << none;
			EXPECT_LT(norm(momentum - given), 1e-5) << none;
			EXPECT_LT(norm(rig.coupling.appliedImpulse(hand.source) - given), 1e-12) << none;
			EXPECT_EQ(hand.source.statistics().worldSteps, static_cast<std::uint64_t>(rig.worldSteps))
				<< none;  // the first step was shown, the last not received
		}
}

// A sleeping body has no new contacts. Its support is known nevertheless, and a push wakes it.
TEST(BulletDecoupled, ASleepingBodyIsFeltAndWakes)
{
	DecoupledRig rig(60, kGravity);
	rig.sleeping = true;
	rig.add(rig.planeShape, 0, {}, 0.3);
	btRigidBody* box = rig.addBox(0.3, {0, 0.02, 0});
	Hand& hand = rig.addHand({-0.055, 0.023, 0});
	hand.script = [](double t) { return ist::Twist{{t > 4 && t < 5 ? 0.03 : 0, 0, 0}, {}}; };
	rig.run(4);
	ASSERT_FALSE(box->isActive());
	const double height = double(box->getWorldTransform().getOrigin().y());
	rig.run(0.3);
	// The body is still at rest although the hand is about to touch it: its copy neither falls nor rises.
	EXPECT_EQ(hand.step.contactCount, 0);
	ist::Pose copy;
	ASSERT_TRUE(hand.source.copyOf(box, copy));
	EXPECT_NEAR(copy.translation.y, height, 1e-4);
	rig.run(1.2);
	EXPECT_TRUE(box->isActive());
	EXPECT_NEAR(double(box->getWorldTransform().getOrigin().x()), 0.015, 0.006);
	// Coulomb's law: the product of the friction coefficients times the weight.
	EXPECT_GT(hand.largest, 0.3 * 0.8 * 0.3 * 9.81);
}

// Between two steps of a slow world the tool slides 20 mm on the contact that was found at the first step.
TEST(BulletDecoupled, ALinearModelCountsAsFarAsItIsTrusted)
{
	for (const double trusted : {0.005, 1.0})
	{
		DecoupledRig rig(5);
		rig.add(rig.boxShape, 0, {0, 0, 0});
		BulletDecoupledSettings settings = handSettings();
		settings.topology = ContactThreading::InWorldThread;
		settings.trustedModel = trusted;
		Hand& hand = rig.addHand({-0.01, 0.0385, 0}, settings);
		hand.script = [](double t) { return ist::Twist{{t > 1 && t <= 1.2 ? 0.1 : 0, 0, 0}, {}}; };
		Vec3 found;
		rig.afterWorldStep = [&] { found = hand.source.toolState().X_WT.translation; };
		rig.run(0.9);
		int near = 0, far = 0, feltNear = 0, feltFar = 0;
		rig.afterTick = [&] {
			const double way = distance(hand.source.toolState().X_WT.translation, found);
			const bool felt = hand.step.contactCount > 0 && norm(hand.step.contacts[0].onTool.force) > 0;
			if (way < 0.0095) ++near, feltNear += felt;
			if (way > 0.0105) ++far, feltFar += felt;
		};
		rig.run(0.3);
		EXPECT_GT(near, 100);
		EXPECT_GT(far, 50);
		EXPECT_EQ(feltNear, near) << trusted;
		EXPECT_EQ(feltFar, trusted < 1 ? 0 : far) << trusted;
	}
}

TEST(BulletDecoupled, ABudgetOfPairsIsKeptAndCounted)
{
	double felt[3] = {};
	const std::int64_t budgets[] = {-1, 20, 1};  // no level answers with one pair
	for (int i = 0; i < 3; ++i)
	{
		DecoupledRig rig(60, kGravity);
		rig.addPlane();
		rig.addBox(0.3, {0, 0.02, 0});
		BulletDecoupledSettings settings = handSettings();
		settings.maxPairs = budgets[i];
		Hand& hand = rig.addHand({0, 0.065, 0}, settings);
		hand.script = pressing(0.008);
		std::int64_t most = 0;
		rig.afterTick = [&] { most = std::max(most, hand.step.pairs); };
		rig.run(2);
		felt[i] = norm(hand.step.coupling.force);
		const DecoupledStatistics statistics = hand.source.statistics();
		EXPECT_EQ(most <= 20, i == 1) << most;
		EXPECT_EQ(statistics.coarsenedQueries > 0, i == 1);
		EXPECT_EQ(statistics.queriesOverBudget > 0, i == 2);
		EXPECT_EQ(statistics.refusedQueries, 0U);
	}
	EXPECT_NEAR(felt[1], felt[0], 0.3 * felt[0]);
	EXPECT_NEAR(felt[2], felt[0], 0.02 * felt[0]);
}
