// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"

#include "BulletISTCollision/btBulletISTCollisionCommon.h"

using namespace scenario;
using ist::Vec3;

// Only the narrow phase is ours, with nothing set: Bullet's own solver carries bodies by the points in the manifolds.
namespace
{
class PlainWorld
{
public:
	explicit PlainWorld(bool floorHasTree)
	{
		m_world.setGravity(btVector3(0, btScalar(-9.81), 0));
		m_registration = btISTCollisionAlgorithm::registerAlgorithm(&m_dispatcher);
		static const Solid slab(ist::makeBoxMesh({2, 0.2, 2}), 1000);
		if (floorHasTree) add(slab, 0, at({0, -0.2, 0}));
		else addBody(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)), 0, btVector3(0, 0, 0), at({}));
	}
	~PlainWorld()
	{
		for (auto& body : m_bodies) m_world.removeRigidBody(body.get());
	}

	btRigidBody* add(const Solid& solid, double mass, const btTransform& pose)
	{
		Vec3 half;
		for (const Vec3& p : solid.mesh.vertices) half = ist::componentMax(half, {std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
		auto shape = std::make_unique<btBoxShape>(vec(half));
		auto attached = m_registration.registry().attach(shape.get(), solid.tree);
		EXPECT_TRUE(attached);
		if (attached) m_attachments.push_back(std::move(attached).value());
		const ist::MassProperties p = ist::massProperties(solid.mesh);
		const double density = mass / p.volume;
		return addBody(
			std::move(shape), mass, vec(Vec3{density * p.inertia.m[0][0], density * p.inertia.m[1][1], density * p.inertia.m[2][2]}), pose);
	}
	void run(double seconds, double rate)
	{
		for (int i = 0; i < int(seconds * rate + 0.5); ++i) m_world.stepSimulation(btScalar(1 / rate), 0);
	}

private:
	btRigidBody* addBody(std::unique_ptr<btCollisionShape> shape, double mass, const btVector3& inertia, const btTransform& pose)
	{
		m_bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, shape.get(), mass > 0 ? inertia : btVector3(0, 0, 0)));
		m_shapes.push_back(std::move(shape));
		btRigidBody* body = m_bodies.back().get();
		body->setWorldTransform(pose);
		body->setInterpolationWorldTransform(pose);
		body->setActivationState(DISABLE_DEACTIVATION);
		body->setFriction(1);
		m_world.addRigidBody(body);
		return body;
	}

	btDefaultCollisionConfiguration m_configuration;
	btCollisionDispatcher m_dispatcher{&m_configuration};
	btDbvtBroadphase m_broadphase;
	btSequentialImpulseConstraintSolver m_solver;
	btDiscreteDynamicsWorld m_world{&m_dispatcher, &m_broadphase, &m_solver, &m_configuration};
	std::vector<std::unique_ptr<btCollisionShape>> m_shapes;
	std::vector<std::unique_ptr<btRigidBody>> m_bodies;
	btISTRegistration m_registration;
	std::vector<btISTAttachment> m_attachments;
};

/// In a plain world on a plane and on a slab with a tree, at 60 and 240 Hz.
class NarrowPhase : public testing::TestWithParam<std::pair<bool, double>>
{
protected:
	PlainWorld world{GetParam().first};
	double rate = GetParam().second;
};
}  // namespace

// Bullet's own boxes stand five high at 240 Hz, and fall at 60 Hz.
TEST_P(NarrowPhase, ATowerOfCubesStands)
{
	static const Solid brick(ist::makeBoxMesh({0.1, 0.1, 0.1}), 1000);
	btRigidBody* body[5];
	const int count = rate > 100 ? 5 : 3;
	for (int i = 0; i < count; ++i) body[i] = world.add(brick, 8, at({0, 0.1 + 0.2 * i, 0}));
	world.run(10, rate);
	for (int i = 0; i < count; ++i)
	{
		// The load is that of one cube, so the depth of each contact grows with what stands on it.
		double sunk = 0;
		for (int j = 0; j <= i; ++j) sunk += 3e-4 * 0.2 * (count - j);
		EXPECT_NEAR(height(body[i]), 0.1 + 0.2 * i - sunk, 0.5 * sunk) << i;
		EXPECT_LT(tilt(body[i]), 0.02) << i;
	}
}

TEST_P(NarrowPhase, ARodStandsOnItsEnd)
{
	static const Solid rod(ist::makeBoxMesh({0.01, 0.25, 0.01}), 1000);
	btRigidBody* body = world.add(rod, 0.5, at({0, 0.25, 0}));
	world.run(5, rate);
	EXPECT_NEAR(height(body), 0.25, 1e-4);
	EXPECT_LT(tilt(body), 0.01);
}

TEST_P(NarrowPhase, ABallLiesOnTheFloor)
{
	static const Solid ball(ist::makeSphereMesh(0.1, 4), 1000);
	btRigidBody* body = world.add(ball, 4, at({0, 0.1, 0}));
	world.run(5, rate);
	EXPECT_GT(height(body), 0.1 - 1e-3) << "half a per cent of its size";
	EXPECT_LT(height(body), 0.1);
}

TEST_P(NarrowPhase, ACubeIsDroppedAndLies)
{
	static const Solid brick(ist::makeBoxMesh({0.1, 0.1, 0.1}), 1000);
	btRigidBody* body = world.add(brick, 8, at({0, 1, 0}, {0.3, 0.5, 0.2}));
	world.run(5, rate);
	EXPECT_NEAR(height(body), 0.1, 2e-4);
	EXPECT_LT(double(body->getLinearVelocity().length()), 1e-3);
}

TEST_P(NarrowPhase, ABoxTipsWhereItsWeightLiesBeyondTheEdge)
{
	static const Solid table(ist::makeBoxMesh({0.75, 0.5, 1.5}), 1000), box(ist::makeBoxMesh({0.5, 0.5, 0.5}), 1000);
	for (const double share : {0.3, 0.4, 0.45, 0.52, 0.6})
	{
		PlainWorld own(GetParam().first);
		own.add(table, 0, at({-0.75, 0.5, 0}));
		btRigidBody* body = own.add(box, 100, at({share - 0.5, 1.501, 0}));
		own.run(4, rate);
		if (share < 0.5) EXPECT_NEAR(height(body), 1.5, 2e-3) << share;
		else EXPECT_LT(height(body), 1.4) << share;
	}
}

INSTANTIATE_TEST_SUITE_P(
	Floors, NarrowPhase, testing::Values(std::pair{false, 60.0}, std::pair{true, 60.0}, std::pair{false, 240.0}, std::pair{true, 240.0}));
