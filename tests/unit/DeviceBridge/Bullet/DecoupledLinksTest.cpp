// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletContactSource.h"
#include "tests/unit/DeviceBridge/Bullet/DecoupledRig.h"

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h"
#include "BulletDynamics/Featherstone/btMultiBody.h"
#include "BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h"
#include "BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h"
#include "BulletDynamics/Featherstone/btMultiBodyJointMotor.h"
#include "BulletDynamics/Featherstone/btMultiBodyLinkCollider.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

using namespace devicebridge;
using ist::Vec3;

namespace
{
constexpr double kLinkMass = 0.5;
enum class Joint
{
	Fixed,      ///< to a fixed base
	Slider,     ///< along x, free
	Motorised,  ///< the slider along y, held by a motor
	Upright     ///< the slider along y, free
};

/// A game with a multibody: a fixed base, and one link, a box of 40 mm without a tree.
struct LinkGame
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btMultiBodyConstraintSolver solver;
	btMultiBodyDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
	btBoxShape box{btVector3(btScalar(kBoxHalf), btScalar(kBoxHalf), btScalar(kBoxHalf))};
	btSphereShape ball{btScalar(kBallRadius)};
	btMultiBody multiBody{1, 0, btVector3(0, 0, 0), true, false};
	btMultiBodyLinkCollider collider{&multiBody, 0};
	std::unique_ptr<btMultiBodyJointMotor> motor;
	std::unique_ptr<btISTWorld> ist;
	btISTAttachment tree;

	LinkGame(Joint joint, double period)
	{
		const btScalar inertia = btScalar(kLinkMass * 4 * kBoxHalf * kBoxHalf / 6);
		const btVector3 inertias(inertia, inertia, inertia), none(0, 0, 0);
		if (joint == Joint::Fixed) multiBody.setupFixed(0, btScalar(kLinkMass), inertias, -1, btQuaternion::getIdentity(), none, none);
		else
			multiBody.setupPrismatic(0, btScalar(kLinkMass), inertias, -1, btQuaternion::getIdentity(),
				joint == Joint::Slider ? btVector3(1, 0, 0) : btVector3(0, 1, 0), none, none, true);
		multiBody.finalizeMultiDof();
		multiBody.setLinearDamping(0);
		multiBody.setAngularDamping(0);
		multiBody.setCanSleep(false);
		world.setGravity(btVector3(0, 0, 0));
		world.addMultiBody(&multiBody);
		collider.setCollisionShape(&box);
		collider.setFriction(btScalar(0.5));
		multiBody.getLink(0).m_collider = &collider;
		world.addCollisionObject(&collider, 1, -1);
		if (joint == Joint::Motorised)
		{
			motor = std::make_unique<btMultiBodyJointMotor>(&multiBody, 0, btScalar(0), btScalar(100 * period));
			motor->setPositionTarget(0, btScalar(0.2));
			world.addMultiBodyConstraint(motor.get());
		}
		ist = std::make_unique<btISTWorld>(world);
		tree = std::move(ist->attach(&ball, ballTree())).value();
		if (ist->materials().set(&collider, {2e7, 2})) throw std::runtime_error("material");
	}
	~LinkGame()
	{
		ist.reset();
		if (motor) world.removeMultiBodyConstraint(motor.get());
		world.removeCollisionObject(&collider);
		world.removeMultiBody(&multiBody);
	}
};

using Script = std::function<ist::Twist(double)>;

std::vector<Vec3> inOneThread(Joint joint, const Script& script, const Vec3& start, int ticks)
{
	LinkGame game(joint, 1e-3);
	btRigidBody tool(Hand::info(game.ball, start));
	if (game.ist->materials().set(&tool, {2e7, 2})) throw std::runtime_error("material");
	game.world.addRigidBody(&tool);
	std::vector<Vec3> forces = forcesInOneThread(*game.ist, tool, start, script, ticks);
	game.world.removeRigidBody(&tool);
	return forces;
}

struct Outcome
{
	std::vector<Vec3> forces;
	Vec3 given;        ///< impulse on the tool from its contacts [N s]
	double speed = 0;  ///< of the joint [m/s]
};

Outcome decoupled(Joint joint, const Script& script, const Vec3& start, int ticks, double rate, bool drain = false)
{
	LinkGame game(joint, 1 / rate);
	VirtualClock clock;
	BulletWorldCoupling coupling(*game.ist);
	Hand hand(*game.ist, game.ball, clock, start, handSettings());
	if (game.ist->materials().set(&hand.body, {2e7, 2})) throw std::runtime_error("material");
	coupling.add(hand.source);
	hand.script = script;
	coupling.show(1 / rate);
	Outcome out;
	std::int64_t steps = 0;
	for (int i = 1; i <= ticks; ++i)
	{
		while (double(steps + 1) / rate <= 1e-9 * double(clock.now()) + 1e-9) coupling.step(1 / rate), ++steps;
		clock.sleepUntil(i * kTickPeriod);
		hand.tick(1e-9 * double(clock.now()));
		out.forces.push_back(hand.step.coupling.force);
	}
	if (drain) coupling.step(1 / rate);
	EXPECT_TRUE(coupling.unfelt().empty()) << coupling.unfeltReport();
	out.given = hand.source.receivedImpulse();
	out.speed = game.multiBody.getNumDofs() > 0 ? double(game.multiBody.getJointVel(0)) : 0;
	coupling.remove(hand.source);
	return out;
}
}  // namespace

// The oracle is one-thread mode, in which the world's own solver finds the force.
TEST(DecoupledLinks, AHeldLinkFeelsAsInOneThread)
{
	const Vec3 start{-0.01, kBoxHalf + kBallRadius + 0.002, 0};
	const Script script = [](double time) {
		const double t = time - 0.1005;
		if (t <= 0) return ist::Twist();
		if (t <= 0.2) return ist::Twist{{0, -0.005 / 0.2, 0}, {}};
		return ist::Twist{{t > 0.9 && t <= 1.1 ? 0.1 : 0, 0, 0}, {}};
	};
	for (const Joint joint : {Joint::Fixed, Joint::Motorised})
		for (const double rate : {60.0, 240.0})
		{
			const std::vector<Vec3> oracle = inOneThread(joint, script, start, 1200),
									forces = decoupled(joint, script, start, 1200, rate).forces;
			const double force = norm(oracle[999]);
			double atRest = 0, sliding = 0;
			for (std::size_t i = 900; i < 1000; ++i) atRest = std::max(atRest, distance(oracle[i], forces[i]) / norm(oracle[i]));
			for (std::size_t i = 1020; i < 1200; ++i) sliding = std::max(sliding, distance(oracle[i], forces[i]) / norm(oracle[i]));
			std::printf("%s link, world at %g Hz: %.2f N, at rest within %.2f %%, sliding within %.2f %%\n",
				joint == Joint::Fixed ? "fixed" : "motorised", rate, force, 100 * atRest, 100 * sliding);
			EXPECT_GT(force, 0.5);
			EXPECT_LT(atRest, 0.02) << rate;
			EXPECT_LT(sliding, 0.1) << rate;
		}
}

// The joint keeps what the hand gave: mass times the joint's speed. It is counted from Bullet's own state.
TEST(DecoupledLinks, AFreeLinkGetsTheImpulseThatTheHandGave)
{
	for (const double rate : {60.0, 240.0, 1000.0})
	{
		const Vec3 start{-(kBoxHalf + kBallRadius + 0.001), 0, 0};
		const Script script = [](double t) { return ist::Twist{{t > 0.1 ? std::min(0.2, t - 0.1) : 0, 0, 0}, {}}; };
		const Outcome out = decoupled(Joint::Slider, script, start, 600, rate, true);
		EXPECT_GT(-out.given.x, 0.05) << rate;
		EXPECT_NEAR(kLinkMass * out.speed, -out.given.x, 0.01 * norm(out.given)) << rate;
		// The hand feels tool and link: the force on both is mass times acceleration, apart from the first touch.
		double largest = 0;
		for (const Vec3& f : out.forces) largest = std::max(largest, norm(f));
		EXPECT_LT(largest, 3 * (kLinkMass + kDecoupledToolMass)) << rate;
		std::printf("slider, world at %g Hz: %.3f m/s, largest force %.2f N\n", rate, out.speed, largest);
	}
}

namespace
{
/// Inverse mass of the hand's copy of the link along an axis [1/kg].
double yieldOf(Hand& hand, const LinkGame& game, int axis)
{
	const int slot = hand.source.mirror().find(&game.collider);
	EXPECT_GE(slot, 0);
	return slot < 0 ? 0 : hand.source.mirror().body(slot).inverseMass[axis];
}
}  // namespace

// The oracle is the mass of the link: it is free along x, whatever the sum of the two hands is.
TEST(DecoupledLinks, AFreeLinkThatTwoHandsSqueezeStaysFree)
{
	LinkGame game(Joint::Slider, 1.0 / 60);
	VirtualClock clock;
	BulletWorldCoupling coupling(*game.ist);
	std::vector<std::unique_ptr<Hand>> hands;
	for (const double side : {-1.0, 1.0})
	{
		hands.push_back(
			std::make_unique<Hand>(*game.ist, game.ball, clock, Vec3{side * (kBoxHalf + kBallRadius + 0.001), 0, 0}, handSettings()));
		if (game.ist->materials().set(&hands.back()->body, {2e7, 2})) throw std::runtime_error("material");
		hands.back()->script = [side](double t) { return ist::Twist{{t > 0.1 && t < 0.3 ? -side * 0.03 : 0, 0, 0}, {}}; };
		coupling.add(hands.back()->source);
	}
	coupling.show(1.0 / 60);
	std::int64_t steps = 0;
	for (int i = 1; i <= 900; ++i)
	{
		while (double(steps + 1) / 60 <= 1e-9 * double(clock.now()) + 1e-9) coupling.step(1.0 / 60), ++steps;
		clock.sleepUntil(i * kTickPeriod);
		for (auto& hand : hands) hand->tick(1e-9 * double(clock.now()));
	}
	for (auto& hand : hands)
	{
		EXPECT_GT(norm(hand->step.coupling.force), 1);
		EXPECT_GT(yieldOf(*hand, game, 0), 0.5 / kLinkMass);
	}
	for (auto& hand : hands) coupling.remove(hand->source);
}

// The hand carries the weight of a link that is free along y. It does not speed up, and it is free all the same.
TEST(DecoupledLinks, ALinkThatAHandCarriesStaysFree)
{
	LinkGame game(Joint::Upright, 1.0 / 60);
	game.world.setGravity(btVector3(0, btScalar(-9.81), 0));
	VirtualClock clock;
	BulletWorldCoupling coupling(*game.ist);
	Hand hand(*game.ist, game.ball, clock, {0, -(kBoxHalf + kBallRadius + 0.0005), 0}, handSettings());
	if (game.ist->materials().set(&hand.body, {2e7, 2})) throw std::runtime_error("material");
	coupling.add(hand.source);
	coupling.show(1.0 / 60);
	std::int64_t steps = 0;
	double sum = 0, least = 1e9;
	for (int i = 1; i <= 1500; ++i)
	{
		while (double(steps + 1) / 60 <= 1e-9 * double(clock.now()) + 1e-9)
		{
			coupling.step(1.0 / 60), ++steps;
			if (i > 500) least = std::min(least, yieldOf(hand, game, 1));
		}
		clock.sleepUntil(i * kTickPeriod);
		hand.tick(1e-9 * double(clock.now()));
		if (i > 1000) sum += hand.step.coupling.force.y / 500;
	}
	std::printf("carried: %.2f N of %.2f N, at least %.2f of the inverse mass\n", sum, 9.81 * kLinkMass, least * kLinkMass);
	EXPECT_NEAR(sum, 9.81 * kLinkMass, 0.1 * 9.81 * kLinkMass);
	EXPECT_GT(least, 0.5 / kLinkMass);
	coupling.remove(hand.source);
}

// A box lies on a link, and both move at 0.5 m/s. The oracle is the pair of poses that Bullet had before the step.
TEST(DecoupledLinks, ContactsOfAMovingLinkAreShownAtThePosesInWhichTheyWereFound)
{
	LinkGame game(Joint::Slider, 1.0 / 60);
	btBoxShape shape{btVector3(btScalar(kBoxHalf), btScalar(kBoxHalf), btScalar(kBoxHalf))};
	const auto attached = std::move(game.ist->attach(&shape, boxTree())).value();
	btRigidBody load(Hand::info(shape, {0.002, 2 * kBoxHalf - 0.0005, 0}));
	load.forceActivationState(DISABLE_DEACTIVATION);
	game.world.addRigidBody(&load);
	load.setLinearVelocity(btVector3(btScalar(0.5), 0, 0));
	game.multiBody.setJointVel(0, btScalar(0.5));
	VirtualClock clock;
	BulletWorldCoupling coupling(*game.ist);
	Hand hand(*game.ist, game.ball, clock, {0.05, 0.02, 0}, handSettings());
	coupling.add(hand.source);
	coupling.show(1.0 / 60);
	for (int step = 0; step < 2; ++step)
	{
		const Vec3 before[2] = {vec3(load.getWorldTransform().getOrigin()), vec3(game.collider.getWorldTransform().getOrigin())};
		coupling.step(1.0 / 60);
		EXPECT_GT(double(game.collider.getWorldTransform().getOrigin().x()) - before[1].x, 0.007);
		WorldMirror& mirror = hand.source.mirror();
		ASSERT_TRUE(mirror.fetch());
		const WorldSnapshot& world = mirror.snapshot();
		ASSERT_GT(world.contactCount, 0);
		const int box = mirror.find(&load), link = mirror.find(&game.collider);
		ASSERT_GE(box, 0);
		ASSERT_GE(link, 0);
		for (int i = 0; i < world.contactCount; ++i)
		{
			const LinearContact& c = world.contacts[std::size_t(i)];
			ASSERT_TRUE((c.a == box && c.b == link) || (c.a == link && c.b == box));
			EXPECT_LT(distance(c.X_WA.translation, before[c.a == link]), 1e-6);
			EXPECT_LT(distance(c.X_WB.translation, before[c.b == link]), 1e-6);
		}
	}
	coupling.remove(hand.source);
	game.world.removeRigidBody(&load);
}
