// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/World/btEnergyAudit.h"
#include "tests/scenario/extremes/ExtremeTest.h"
#include "tests/unit/CountingAllocator.h"

#include <random>

using namespace extremes;

namespace
{
/// Rounding of velocities and poses over some thousand steps, as a share of the energy.
constexpr double kRounding = kDouble ? 1e-10 : 1e-4;

struct Audited
{
	ExtremeWorld world;
	btEnergyAudit audit;
	double h;

	Audited(double gravity, double step)
		: world(Response::Volumetric, gravity),
		  audit(world.bullet(), world.volumetric().contacts()),
		  h(step)
	{}
	void step()
	{
		audit.beforeStep(h);
		world.step(h);
		audit.afterStep();
	}
	void steps(int count)
	{
		for (int i = 0; i < count; ++i) step();
	}
	void expectClosed(double energy) const
	{
		const btEnergyBalance& t = audit.total();
		EXPECT_NEAR(t.residual, 0, kRounding * energy);
		EXPECT_NEAR(t.kinetic + t.potential + t.contact, t.injected - t.physical - t.numerical + t.residual, kRounding * energy);
	}
};
}  // namespace

// Bullet moves a body with the velocity at the end of the step, so each step loses exactly m g^2 h^2 / 2.
TEST(EnergyAudit, FreeFlightLosesWhatTheIntegratorLoses)
{
	Audited scene(kGravity, 1.0 / 240);
	btRigidBody* body = scene.world.add(unitCube(), 3, 0.5, transformOf({2, 5, -1}, {0.3, 0.2, 0.9}));
	body->setLinearVelocity(btVector3(1, 4, 2));
	body->setAngularVelocity(btVector3(3, -1, 2));
	const double before = 0.5 * 3 * 21 + 0.5 * 0.5 * 14 + 3 * kGravity * 5;
	scene.steps(481);  // the balance ends at the beginning of the last step
	const btEnergyBalance& total = scene.audit.total();
	const double lost = 480 * 0.5 * 3 * kGravity * kGravity * scene.h * scene.h;
	EXPECT_NEAR(total.injected, before, kRounding * before);
	EXPECT_NEAR(total.numerical, lost, kDouble ? 1e-9 * before : 2e-2 * lost);
	EXPECT_NEAR(total.physical, 0, kRounding * before);
	scene.expectClosed(before);
}

TEST(EnergyAudit, ForceInjectsItsWork)
{
	Audited scene(0, 1.0 / 240);
	btRigidBody* body = scene.world.add(unitCube(), 2, 1, transformOf({0, 1, 0}));
	for (int i = 0; i < 241; ++i)
	{
		body->applyCentralForce(btVector3(3, 0, 4));
		body->applyTorque(btVector3(0, 2, 0));
		scene.step();
	}
	// The work after one second is (F t)^2 / 2 m + (M t)^2 / 2 I.
	EXPECT_NEAR(scene.audit.total().injected, 25.0 / 4 + 4.0 / 2, kRounding * 10);
	scene.expectClosed(10);
	body->setLinearVelocity(btVector3(0, 0, 0));
	body->setAngularVelocity(btVector3(0, 0, 0));
	scene.steps(2);
	EXPECT_NEAR(scene.audit.total().injected, 0, kRounding * 10);
}

// The body has three different moments of inertia. The effects of Bullet's gyroscopic term and of the rotating inertia are numerical.
TEST(EnergyAudit, TumblingBodyLeavesNoResidual)
{
	Audited scene(0, 1.0 / 60);
	btRigidBody* body = scene.world.add(unitCube(), 1, 1, transformOf({0, 0, 0}, {0.5, 1, 0}));
	body->setMassProps(1, btVector3(1, 2, 5));
	body->updateInertiaTensor();
	body->setAngularVelocity(btVector3(1, 6, 1));
	scene.steps(600);
	EXPECT_GT(scene.audit.total().numerical, 0.1);
	scene.expectClosed(70);
}

TEST(EnergyAudit, BounceDissipatesWhatHuntAndCrossleySay)
{
	const double k = 1e3, dv = 0.5, mass = 1, omega = std::sqrt(k / mass);
	Audited scene(0, 0.006 / omega);
	btRigidBody* floor = scene.world.addFloor();
	btRigidBody* body = scene.world.add(unitCube(), mass, 1, transformOf({0.2, 0.6, -0.1}), k);
	ASSERT_FALSE(scene.world.volumetric().materials().set(body, {k, dv}));
	ASSERT_TRUE(floor);
	body->setAngularFactor(btScalar(0));
	body->setLinearVelocity(btVector3(0, -1, 0));
	scene.steps(3000);
	ASSERT_GT(body->getWorldTransform().getOrigin().y(), 0.6);
	const double e = huntCrossleyRestitution(dv), exact = 0.5 * mass * (1 - e * e);
	const btEnergyBalance& total = scene.audit.total();
	std::printf("  physical %.5f J, closed form %.5f J, numerical %.5f J, residual %.1e J\n", total.physical, exact, total.numerical,
		total.residual);
	EXPECT_NEAR(total.physical, exact, 0.02 * exact);
	EXPECT_GT(total.numerical, 0);
	EXPECT_LT(total.numerical, 0.03);
	EXPECT_NEAR(total.contact, 0, 1e-12);
	scene.expectClosed(0.5);
}

TEST(EnergyAudit, FrictionDissipatesForceTimesWay)
{
	const double mass = 2, friction = 0.4, k = 800, v = 3;
	const ExtremeSolid slab = solidOf(ist::makeBoxMesh({0.5, 0.1, 0.5}), 500);
	Audited scene(kGravity, 1e-3);
	scene.world.addFloor()->setFriction(1);
	btRigidBody* body = scene.world.add(slab, mass, mass / 12, transformOf({-3, 0.1 - mass * kGravity / k, 2}), k);
	body->setFriction(btScalar(friction));
	scene.steps(2000);
	const btEnergyBalance before = scene.audit.total();
	const double from = double(body->getWorldTransform().getOrigin().x());
	body->setLinearVelocity(btVector3(btScalar(v), 0, 0));
	scene.steps(2000);
	const double way = double(body->getWorldTransform().getOrigin().x()) - from, exact = friction * mass * kGravity * way;
	const btEnergyBalance& after = scene.audit.total();
	std::printf("  way %.4f m, friction %.4f J, closed form %.4f J\n", way, after.physical - before.physical, exact);
	EXPECT_NEAR(way, v * v / (2 * friction * kGravity), 0.01 * way);
	EXPECT_NEAR(after.physical - before.physical, exact, 0.01 * exact);
	EXPECT_NEAR(after.injected - before.injected, 0.5 * mass * v * v, 0.01 * exact);
	scene.expectClosed(0.5 * mass * v * v);
}

TEST(EnergyAudit, LiftInjectsTheWeightTimesTheHeight)
{
	Audited scene(kGravity, 1.0 / 240);
	btRigidBody* lift = scene.world.add(unitCube(), 0, 0, transformOf({0, -0.5, 0}), 1e3);
	lift->setCollisionFlags(lift->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
	btRigidBody* body = scene.world.add(unitCube(), 2, 0.3, transformOf({0, 0.47, 0}), 1e3);
	scene.steps(2400);
	const double before = scene.audit.total().injected, from = double(body->getWorldTransform().getOrigin().y());
	for (int i = 0; i < 480; ++i)
	{
		const btScalar y = btScalar(-0.5 + 0.5 * (1 - std::cos(3.14159265358979 * (i + 1) / 480)));
		lift->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, y, 0)));
		scene.step();
	}
	scene.steps(1200);
	const double risen = double(body->getWorldTransform().getOrigin().y()) - from;
	EXPECT_NEAR(risen, 1, 0.01);
	EXPECT_NEAR(scene.audit.total().injected - before, 2 * kGravity * risen, 0.01 * 2 * kGravity * risen);
	scene.expectClosed(2 * kGravity);
}

TEST(EnergyAudit, CollisionsLoseWhatWasDissipated)
{
	double worst = 0, physical = 0, numerical = 0;
	int touched = 0;
	for (uint64_t seed = 0; seed < 200; ++seed)
	{
		std::mt19937_64 random(3000 + seed);
		const auto uniform = [&](double from, double to) { return std::uniform_real_distribution<double>(from, to)(random); };
		CollisionSetup setup;
		setup.k = std::pow(10, uniform(3, 8));
		setup.h = 1 / std::pow(10, uniform(1.5, 3));
		setup.speed = uniform(0.5, 8);
		setup.friction = uniform(0, 1);
		const CollisionOutcome out = collide(Response::Volumetric, unitCube(), setup, seed);
		touched += out.touched;
		const double unnamed = 1 - out.energy - out.physical - out.numerical - out.stored;
		EXPECT_NEAR(unnamed, 0, kDouble ? 1e-10 : 1e-4) << seed;
		EXPECT_GE(out.physical, kDouble ? -1e-10 : -1e-4) << seed;
		worst = std::max(worst, std::fabs(unnamed));
		physical += out.physical / 200;
		numerical += out.numerical / 200;
	}
	std::printf(
		"  of the kinetic energy, in the mean: physical %.3f, numerical %.3f; without a name at most %.1e\n", physical, numerical, worst);
	EXPECT_GT(touched, 180);
}

// A contact that is limited to its energy tank changes the motion of its neighbours in the pile. Their work must be computed after that.
TEST(EnergyAudit, PileWhoseContactsAreHeldBackLeavesNoResidual)
{
	Audited scene(kGravity, 1.0 / 120);
	scene.world.addFloor();
	std::mt19937_64 random(4);
	std::uniform_real_distribution<double> u(-0.5, 0.5);
	double energy = 0;
	for (int i = 0; i < 8; ++i)
	{
		const double height = 0.9 + 1.3 * i;
		scene.world.add(unitCube(), 1, 1.0 / 6, transformOf({u(random), height, u(random)}, {u(random), u(random), u(random)}), 1e9);
		energy += kGravity * height;
	}
	scene.steps(360);
	const auto held = scene.world.volumetric().statistics().contactsHeldToEnergyTank;
	std::printf(
		"  %llu contacts held, residual %.1e of %.0f J\n", static_cast<unsigned long long>(held), scene.audit.total().residual, energy);
	EXPECT_GT(held, 2u);
	scene.expectClosed(energy);
	EXPECT_LT(scene.audit.total().kinetic + scene.audit.total().potential, energy);
}

TEST(EnergyAudit, AllocatesNothingOnceItHasSeenTheWorld)
{
	Audited scene(kGravity, 1.0 / 240);
	scene.world.addFloor();
	scene.world.add(unitCube(), 1, 0.2, transformOf({0, 0.49, 0}), 1e4);
	scene.world.add(unitCube(), 1, 0.2, transformOf({0, 1.47, 0}), 1e4);
	scene.steps(3);
	const long before = allocationCount();
	for (int i = 0; i < 50; ++i)
	{
		scene.audit.beforeStep(scene.h);
		scene.audit.afterStep();
	}
	EXPECT_EQ(allocationCount(), before);
}
