// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"

#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

/// The tree of a cube of 1 m.
inline std::shared_ptr<const ist::InnerSphereTree> boxTree()
{
	static const auto tree = [] {
		ist::BuildOptions options;
		options.maxSpheres = 500;
		auto built = ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options);
		return std::make_shared<const ist::InnerSphereTree>(std::move(built).value());
	}();
	return tree;
}

inline btTransform at(double x, double y, double z)
{
	return btTransform(btQuaternion::getIdentity(), btVector3(btScalar(x), btScalar(y), btScalar(z)));
}

/// A world with Bullet's own solver and steps of 1/60 s, without any part of this library.
struct TestWorld
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	std::unique_ptr<btDiscreteDynamicsWorld> world = std::make_unique<btDiscreteDynamicsWorld>(
		&dispatcher, &broadphase, &solver, &configuration);
	std::vector<std::unique_ptr<btRigidBody>> bodies;

	TestWorld() { world->setGravity(btVector3(0, btScalar(-9.81), 0)); }
	~TestWorld()
	{
		for (auto& b : bodies) world->removeRigidBody(b.get());
		world.reset();
	}
	btRigidBody* add(btCollisionShape* shape, double mass, const btTransform& pose)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
		bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, shape, inertia));
		bodies.back()->setWorldTransform(pose);
		bodies.back()->setInterpolationWorldTransform(pose);
		world->addRigidBody(bodies.back().get());
		return bodies.back().get();
	}
	void step(int count)
	{
		for (int i = 0; i < count; ++i) world->stepSimulation(btScalar(1.0 / 60), 0);
	}
	int points() const
	{
		int n = 0;
		for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
			n += const_cast<btCollisionDispatcher&>(dispatcher).getManifoldByIndexInternal(i)->getNumContacts();
		return n;
	}
};

/// Collects the result of a contact test of Bullet.
struct CollectPoints : btCollisionWorld::ContactResultCallback
{
	int count = 0;
	btVector3 normal{0, 0, 0};  // normal on the second object, at the deepest point
	double deepest = 0;
	btScalar addSingleResult(
		btManifoldPoint& p, const btCollisionObjectWrapper*, int, int, const btCollisionObjectWrapper*, int, int) override
	{
		++count;
		if (double(p.getDistance()) < deepest || count == 1) normal = p.m_normalWorldOnB;
		deepest = std::min(deepest, double(p.getDistance()));
		return 0;
	}
};

/// The tree of the cube without a surface: contact is that of the leaves.
inline std::shared_ptr<const ist::InnerSphereTree> leavesOfBox()
{
	static const auto tree = [] {
		auto made = std::make_shared<ist::InnerSphereTree>(*boxTree());
		made->surface = {};
		return made;
	}();
	return tree;
}

/// Attaches the tree of the cube to `shape` in the registry while the returned attachment lives.
inline btISTAttachment attach(btISTRegistration& r, const btCollisionShape& shape, decltype(boxTree()) tree = boxTree())
{
	auto result = r.registry().attach(&shape, tree);
	EXPECT_TRUE(result) << (result ? "" : result.error().message);
	return result ? std::move(result).value() : btISTAttachment();
}
