// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"
#include "tests/unit/CountingAllocator.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <functional>
#include <utility>

using namespace scenario;
using ist::Vec3;

namespace
{
constexpr double kMass = 2, kGravity = 9.81;

/// A world of multibodies whose solver was replaced by ours, as a game would do it.
struct LinkScene
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btISTRegistration registration = btISTCollisionAlgorithm::registerAlgorithm(&dispatcher, broadphase.getOverlappingPairCache());
	std::shared_ptr<btContactMaterialTable> materials = std::make_shared<btContactMaterialTable>();
	btMultiBodyConstraintSolver stock;
	btMultiBodyDynamicsWorld world{&dispatcher, &broadphase, &stock, &configuration};
	std::unique_ptr<btSequentialImpulseConstraintSolver> solver;
	std::vector<std::unique_ptr<btCollisionShape>> shapes;
	std::vector<btISTAttachment> attachments;
	std::vector<std::unique_ptr<btRigidBody>> bodies;
	std::vector<std::unique_ptr<btMultiBody>> multiBodies;
	std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders;

	LinkScene()
	{
		registration.setPairRule(materials);
		world.setGravity(btVector3(0, btScalar(-kGravity), 0));
		auto installed = installVolumetricSolver(world, registration);
		EXPECT_TRUE(installed);
		if (installed) solver = std::move(installed).value();
		EXPECT_EQ(world.getConstraintSolver(), solver.get());
	}
	~LinkScene()
	{
		for (auto& c : colliders) world.removeCollisionObject(c.get());
		for (auto& m : multiBodies) world.removeMultiBody(m.get());
		for (auto& b : bodies) world.removeRigidBody(b.get());
	}
	template <class Shape, class... Arguments> Shape* shape(Arguments&&... arguments)
	{
		shapes.push_back(std::make_unique<Shape>(std::forward<Arguments>(arguments)...));
		return static_cast<Shape*>(shapes.back().get());
	}
	btCollisionShape* volumetricShape(const Solid& solid)
	{
		btVector3 half(0, 0, 0);
		for (const Vec3& p : solid.mesh.vertices) half.setMax(vec(p).absolute());
		btCollisionShape* result = shape<btBoxShape>(half);
		auto attached = registration.registry().attach(result, solid.tree);
		EXPECT_TRUE(attached);
		if (attached) attachments.push_back(std::move(attached).value());
		return result;
	}
	btRigidBody* addRigid(btCollisionShape* s, double mass, double inertia, const btTransform& pose)
	{
		const btScalar i = btScalar(mass > 0 ? inertia : 0);
		bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, s, btVector3(i, i, i)));
		btRigidBody* body = bodies.back().get();
		body->setWorldTransform(pose);
		body->setInterpolationWorldTransform(pose);
		body->setActivationState(DISABLE_DEACTIVATION);
		world.addRigidBody(body);
		return body;
	}
	/// Adds a multibody: a base of `baseMass` (0: fixed) with room for links, which `build` sets up.
	btMultiBody* addMultiBody(
		int links, double baseMass, double inertia, const Vec3& p, const std::function<void(btMultiBody&)>& build = {})
	{
		const btScalar i = btScalar(inertia);
		multiBodies.push_back(std::make_unique<btMultiBody>(links, btScalar(baseMass), btVector3(i, i, i), baseMass == 0, false));
		btMultiBody* m = multiBodies.back().get();
		m->setBasePos(vec(p));
		if (build) build(*m);
		m->finalizeMultiDof();
		m->setLinearDamping(0);
		m->setAngularDamping(0);
		world.addMultiBody(m);
		return m;
	}
	/// Adds a multibody of one light link, which slides along x from a fixed base.
	btMultiBody* addSlidingLink(const Vec3& p)
	{
		return addMultiBody(1, 0, 0, p, [](btMultiBody& body) {
			const btVector3 inertia(btScalar(1e-4), btScalar(1e-4), btScalar(1e-4)), none(0, 0, 0);
			body.setupPrismatic(0, btScalar(0.1), inertia, -1, btQuaternion(0, 0, 0, 1), btVector3(1, 0, 0), none, none, true);
		});
	}
	/// `k` 0: nothing is set.
	btMultiBodyLinkCollider* addCollider(btMultiBody* m, int link, btCollisionShape* s, double k)
	{
		colliders.push_back(std::make_unique<btMultiBodyLinkCollider>(m, link));
		btMultiBodyLinkCollider* c = colliders.back().get();
		c->setCollisionShape(s);
		c->setActivationState(DISABLE_DEACTIVATION);
		(link < 0 ? void(m->setBaseCollider(c)) : void(m->getLink(link).m_collider = c));
		btAlignedObjectArray<btQuaternion> rotations;
		btAlignedObjectArray<btVector3> origins;
		m->forwardKinematics(rotations, origins);
		m->updateCollisionObjectWorldTransforms(rotations, origins);
		world.addCollisionObject(c, 1, -1);
		if (k > 0)
		{
			EXPECT_FALSE(materials->set(c, {k, -1}));
		}
		return c;
	}
	void run(double seconds, double rate)
	{
		for (int i = 0; i < int(seconds * rate); ++i) world.stepSimulation(btScalar(1 / rate), 0);
	}
	/// See the functions of the same names in VolumetricScene.h.
	double momentOn(const btCollisionObject* object, const Vec3& axis) { return scenario::momentOn(registration.store(), object, axis); }
	Vec3 impulseOn(const btCollisionObject* object) { return scenario::impulseOn(registration.store(), object); }
};

btQuaternion turned(const Vec3& rotation) { return at({}, rotation).getRotation(); }
}  // namespace

// A multibody without links is a rigid body: both must tumble onto the floor along the same path.
TEST(MultiBody, FreeBaseMovesLikeARigidBody)
{
	for (const auto& [friction, rolling] : {std::pair(0., 0.), std::pair(.6, 0.), std::pair(.6, .05)})
	{
		LinkScene scene;
		const double rate = 240, k = 1e4;
		scene.world.getSolverInfo().m_numIterations = 200;  // a link's friction converges in Bullet's iterations, a body's in our own
		btRigidBody* floor = scene.addRigid(scene.shape<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)), 0, 0, at({}));
		floor->setFriction(1);
		btCollisionShape* s = scene.volumetricShape(cube());
		const Vec3 tilt{0.3, 0.2, 0.4}, spin{0.5, -1, 0.3}, speed{0.4, 0, -0.2};
		btRigidBody* rigid = scene.addRigid(s, kMass, kMass / 6, at({-5, 0.9, 3}, tilt));
		EXPECT_FALSE(scene.materials->set(rigid, {k, -1}));
		btMultiBody* m = scene.addMultiBody(
			0, kMass, kMass / 6, {5, 0.9, 3}, [&](btMultiBody& b) { b.setWorldToBaseRot(turned(tilt).inverse()); });
		btMultiBodyLinkCollider* collider = scene.addCollider(m, -1, s, k);
		for (btCollisionObject* o : {static_cast<btCollisionObject*>(rigid), static_cast<btCollisionObject*>(collider)})
		{
			o->setFriction(btScalar(friction));
			o->setRollingFriction(btScalar(rolling));
		}
		rigid->setLinearVelocity(vec(speed));
		rigid->setAngularVelocity(vec(spin));
		m->setBaseVel(vec(speed));
		m->setBaseOmega(vec(spin));
		double pushed = 0, worst = 0;
		for (int i = 0; i < int(0.7 * rate); ++i)
		{
			scene.run(1 / rate, rate);
			pushed += norm(scene.impulseOn(collider));
			worst = std::max(worst, double((m->getBasePos() - rigid->getWorldTransform().getOrigin() - btVector3(10, 0, 0)).length()));
		}
		EXPECT_GT(pushed, kMass * 2);
		EXPECT_LT(worst, kDouble ? 1e-5 : 1e-3) << friction << ' ' << rolling;
		EXPECT_LT(double((m->getBaseVel() - rigid->getLinearVelocity()).length()), kDouble ? 1e-4 : 1e-2);
	}
}

namespace
{
/// A bar of 2 m that rotates about its left end on a fixed base, above a small ball at the distance `kLever` from the axis.
struct LeverLink : LinkScene
{
	static constexpr double kLever = 1.7;
	btMultiBody* m;
	btMultiBodyLinkCollider* beam;

	LeverLink()
	{
		const double ball = 0.15, depth = 0.02;
		addRigid(shape<btSphereShape>(btScalar(ball)), 0, 0, at({5 + kLever - 1, 3 - 0.1 - ball + depth, -4}));
		m = addMultiBody(1, 0, 0, {4, 3, -4}, [](btMultiBody& b) {
			b.setupRevolute(0, btScalar(kMass), btVector3(1, 1, 1) * btScalar(0.7), -1, btQuaternion::getIdentity(), btVector3(0, 0, 1),
				btVector3(0, 0, 0), btVector3(1, 0, 0));
		});
		beam = addCollider(m, 0, volumetricShape(bar()), 1e7);
	}
	/// Mean moment of the ball on the beam about the joint over half a second, while `torque` also acts in the joint [N m].
	double meanMoment(double torque = 0)
	{
		double sum = 0;
		for (int i = 0; i < 120; ++i)
		{
			m->addJointTorque(0, btScalar(torque));
			run(1.0 / 240, 240);
			sum += momentOn(beam, vec(m->getBasePos())) * 240 / 120;
		}
		return sum;
	}
};
}  // namespace

// The moments about the joint are those of the weight at 1 m and of the ball at the lever. The fixed base carries the rest.
TEST(MultiBody, HingedLinkLeansOnABallAsTheLeverSays)
{
	LeverLink scene;
	scene.run(3, 240);
	EXPECT_NEAR(scene.meanMoment(), kMass * kGravity, 1e-3 * kMass * kGravity);
	EXPECT_NEAR(scene.impulseOn(scene.beam).y * 240, kMass * kGravity / LeverLink::kLever, 0.02 * kMass * kGravity);
	EXPECT_LT(std::fabs(double(scene.m->getJointVel(0))), 1e-3);
}

TEST(MultiBody, JointTorqueAddsToTheWeight)
{
	LeverLink scene;
	constexpr double kDown = -25;
	for (int i = 0; i < 6; ++i) scene.meanMoment(kDown);
	EXPECT_NEAR(scene.meanMoment(kDown), kMass * kGravity - kDown, 1e-3 * kMass * kGravity);
}

// Bullet's own rows and ours act on one link: a motor at its limit holds part of the weight.
TEST(MultiBody, MotorAndContactShareTheLoad)
{
	LeverLink scene;
	const double torque = 12, rate = 240;
	btMultiBodyJointMotor motor(scene.m, 0, btScalar(100), btScalar(torque / rate));
	scene.world.addMultiBodyConstraint(&motor);
	motor.finalizeMultiDof();
	scene.run(3, rate);
	EXPECT_NEAR(scene.meanMoment(), kMass * kGravity - torque, 2e-3 * kMass * kGravity);
	scene.world.removeMultiBodyConstraint(&motor);
}

// A light link on a prismatic joint presses a block with the force of its motor, at Bullet's ten iterations and a slow target.
TEST(MultiBody, MotorPressesWithItsForce)
{
	static const Solid finger(ist::makeBoxMesh({0.01, 0.02, 0.03}), 500), block(ist::makeBoxMesh({0.05, 0.05, 0.05}), 500);
	for (const double rate : {60.0, 240.0})
		for (const double force : {10.0, 40.0, 200.0})
			for (const double k : {1e8, 1e7})
			{
				if (force > 4e-6 * k) continue;  // deeper than the link bears
				LinkScene scene;
				scene.world.setGravity(btVector3(0, 0, 0));
				scene.addRigid(scene.volumetricShape(block), 0, 0, at({2, 1, -3}));
				btMultiBody* m = scene.addSlidingLink({2.061, 1, -3});
				btMultiBodyLinkCollider* link = scene.addCollider(m, 0, scene.volumetricShape(finger), k);
				btMultiBodyJointMotor motor(m, 0, btScalar(-0.05), btScalar(force / rate));
				scene.world.addMultiBodyConstraint(&motor);
				motor.finalizeMultiDof();
				scene.run(1, rate);
				EXPECT_NEAR(rate * scene.impulseOn(link).x, force, 0.02 * force) << rate << " Hz, k " << k;
				EXPECT_LT(std::fabs(double(m->getJointVel(0))), 1e-3);
				motor.setVelocityTarget(btScalar(0.05));
				scene.run(3 / rate + 1e-3, rate);
				EXPECT_NEAR(double(m->getJointVel(0)), 0.05, 1e-3) << rate << " Hz, k " << k;
				scene.world.removeMultiBodyConstraint(&motor);
			}
}

// A link that a motor closes on a ball stops there, although nothing has pressed before.
TEST(MultiBody, MotorIsKnownBeforeItPresses)
{
	static const Solid finger(ist::makeBoxMesh({0.01, 0.02, 0.03}), 500), ball(ist::makeSphereMesh(0.03, 4), 500);
	for (const double rate : {60.0, 240.0})
		for (const double force : {10.0, 40.0, 200.0})
		{
			LinkScene scene;
			scene.world.setGravity(btVector3(0, 0, 0));
			scene.addRigid(scene.volumetricShape(ball), 0, 0, at({2, 1, -3}));
			btMultiBody* m = scene.addSlidingLink({2.045, 1, -3});
			btMultiBodyLinkCollider* link = scene.addCollider(m, 0, scene.volumetricShape(finger), 0);
			btMultiBodyJointMotor motor(m, 0, btScalar(-0.05), btScalar(force / rate));
			scene.world.addMultiBodyConstraint(&motor);
			motor.finalizeMultiDof();
			double deepest = 0;
			for (int i = 0; i < int(rate); ++i)
			{
				scene.run(1.01 / rate, rate);
				deepest = std::max(deepest, -0.005 - double(m->getJointPos(0)));
			}
			EXPECT_NEAR(rate * scene.impulseOn(link).x, force, 0.02 * force) << rate;
			EXPECT_LT(deepest, 1e-3) << rate << " Hz, " << force << " N";
			EXPECT_LT(-0.005 - double(m->getJointPos(0)), 2e-4) << rate << " Hz, " << force << " N";
			scene.world.removeMultiBodyConstraint(&motor);
		}
}

namespace
{
/// Adds the linear momentum, and the angular momentum about the origin, of a multibody with isotropic inertias.
void addMomentum(const btMultiBody& m, double inertia, Vec3& linear, Vec3& angular)
{
	std::vector<btVector3> omega(size_t(m.getNumLinks()) + 1), velocity(omega.size());
	m.compTreeLinkVelocities(omega.data(), velocity.data());
	for (int link = -1; link < m.getNumLinks(); ++link)
	{
		const double mass = double(link < 0 ? m.getBaseMass() : m.getLinkMass(link));
		const Vec3 v = vec(m.localDirToWorld(link, velocity[size_t(link + 1)])), w = vec(m.localDirToWorld(link, omega[size_t(link + 1)]));
		const Vec3 p = vec(m.localPosToWorld(link, btVector3(0, 0, 0)));
		linear += mass * v;
		angular += mass * cross(p, v) + inertia * w;
	}
}
}  // namespace

// A free body of two links flies into a free cube: one gains the momentum that the other loses.
TEST(MultiBody, KeepsTheMomentumWithARigidBodyItHits)
{
	std::mt19937_64 random(3);
	for (int pose = 0; pose < 3; ++pose)
	{
		LinkScene scene;
		scene.world.setGravity(btVector3(0, 0, 0));
		const double inertia = kMass / 6, rate = 1000, speed = 3;
		btCollisionShape* s = scene.volumetricShape(cube());
		const Vec3 place = randomVector(random, 4), aside = randomVector(random, 0.2);
		btMultiBody* m = scene.addMultiBody(1, kMass, inertia, place, [&](btMultiBody& b) {
			b.setupRevolute(0, btScalar(kMass), btVector3(1, 1, 1) * btScalar(inertia), -1, btQuaternion::getIdentity(), btVector3(0, 0, 1),
				btVector3(0, btScalar(0.7), 0), btVector3(0, btScalar(0.7), 0), true);
		});
		scene.addCollider(m, -1, s, 1e5);
		scene.addCollider(m, 0, s, 1e5);
		btRigidBody* body = scene.addRigid(s, kMass, inertia, at(place + Vec3{1.2, 1.4, 0} + aside, randomVector(random, 0.2)));
		EXPECT_FALSE(scene.materials->set(body, {1e5, -1}));
		m->setBaseVel(btVector3(btScalar(speed), 0, 0));
		Vec3 linear, angular, linearAfter, angularAfter;
		addMomentum(*m, inertia, linear, angular);
		double bent = 0;
		for (int i = 0; i < int(0.4 * rate); ++i)
		{
			scene.run(1 / rate, rate);
			bent = std::max(bent, std::fabs(double(m->getJointVel(0))));
		}
		addMomentum(*m, inertia, linearAfter, angularAfter);
		const Vec3 given = kMass * vec(body->getLinearVelocity());
		linearAfter += given;
		angularAfter += cross(vec(body->getWorldTransform().getOrigin()), given) + inertia * vec(body->getAngularVelocity());
		const double momentum = 2 * kMass * speed;
		EXPECT_GT(norm(given), 0.2 * momentum);
		EXPECT_GT(bent, 0.5);
		// Bullet integrates the joint's Coriolis force to first order in the step.
		EXPECT_LT(norm(linearAfter - linear), 0.01 * momentum);
		EXPECT_LT(norm(angularAfter - angular), 0.01 * momentum);
	}
}

// A link is turned against another link of the same multibody, which a spring in its joint holds. Their contact forces balance the torque
// in one joint and the spring in the other.
TEST(MultiBody, LinksOfOneBodyPressEachOther)
{
	LinkScene scene;
	scene.world.setGravity(btVector3(0, 0, 0));
	const double rate = 240, torque = 10, gap = 0.98, spring = 2000, damper = 200;
	btCollisionShape* s = scene.volumetricShape(cube());
	btMultiBody* m = scene.addMultiBody(2, 0, 0, {1, 2, 3}, [&](btMultiBody& b) {
		for (int i = 0; i < 2; ++i)
			b.setupRevolute(i, btScalar(kMass), btVector3(1, 1, 1) * btScalar(kMass / 6), -1, btQuaternion::getIdentity(),
				btVector3(0, 0, 1), btVector3(btScalar(i == 0 ? -gap / 2 : gap / 2), 0, 0), btVector3(0, 2, 0));
	});
	m->setHasSelfCollision(true);
	btMultiBodyLinkCollider* left = scene.addCollider(m, 0, s, 5e3);
	btMultiBodyLinkCollider* right = scene.addCollider(m, 1, s, 5e3);
	double onLeft = 0, onRight = 0;
	for (int i = 0; i < int(4 * rate); ++i)
	{
		m->addJointTorque(0, btScalar(-torque));
		m->addJointTorque(1, btScalar(-spring * double(m->getJointPos(1)) - damper * double(m->getJointVel(1))));
		scene.run(1 / rate, rate);
		if (i < int(3 * rate)) continue;
		onLeft += scene.momentOn(left, Vec3{1 - gap / 2, 2, 3});
		onRight += scene.momentOn(right, Vec3{1 + gap / 2, 2, 3});
	}
	EXPECT_NEAR(onLeft, torque, 5e-3 * torque);
	EXPECT_NEAR(onRight, spring * double(m->getJointPos(1)), 5e-3 * torque);
	EXPECT_NEAR(double(left->getWorldTransform().getOrigin().y()), 4, 0.05);
	EXPECT_LT(std::fabs(double(m->getJointVel(0))), 1e-3);
}

TEST(MultiBody, StepAllocatesNothingAfterWarmUp)
{
	LeverLink scene;
	scene.run(0.5, 240);
	const long before = allocationCount();
	scene.run(0.5, 240);
	EXPECT_EQ(allocationCount() - before, 0);
	EXPECT_GT(norm(scene.impulseOn(scene.beam)), 0);
}
