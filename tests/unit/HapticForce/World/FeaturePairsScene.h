// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Law/btEnergyLaw.h"
#include "BulletHapticForce/Law/btPaperLaw.h"
#include "BulletHapticForce/World/btISTSceneReport.h"
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "tests/unit/KeptTree.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <array>
#include <memory>

/// The world in which features are switched: bodies with and without trees, each on another kind of ground.
namespace feature_pairs
{
constexpr double kStep = 1.0 / 120;                                     // [s]
constexpr int kOn = 10, kBoth = 20, kOne = 20, kOff = 40, kFresh = 10;  // steps of the phases of a pair
constexpr int kMeasured = 10;                                           // last steps of a phase, over which forces are averaged
constexpr double kMass = 3, kAccepted = 0.1, kAcceptedOfUpper = 0.2, kKept = 0.1;
const btVector3 kBase(30, 20, -10);  // of the scene, far from the origin [m]

/// So many leaves that pairs of them are worth a memory, and a thread.
inline const auto& levelledTree()
{
	static const auto tree = keptTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), "cube_1m_1000.ist", 1000);
	return tree;
}
inline const auto& plainTree()
{
	static const auto tree = [] {
		ist::InnerSphereTree copy = *levelledTree();
		copy.levels.clear();
		return std::make_shared<const ist::InnerSphereTree>(std::move(copy));
	}();
	return tree;
}
inline const auto& coarseTree()
{
	static const auto tree = keptTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), "coarse_cube_1m.ist", 200);
	return tree;
}

enum Name
{
	Table,    ///< static, a tree
	Lower,    ///< on the table, a tree: tree on tree
	Upper,    ///< on `Lower`, a tree with levels: tree on tree
	Plane,    ///< static
	OnPlane,  ///< the shape of `Lower` on the plane
	Box,      ///< static, without a tree
	OnBox,    ///< the shape of `Upper` on the box: closed form
	Ball,     ///< without a tree, on the plane: Bullet's own contact
	Extra,    ///< the shape of `Upper` on the plane; in the world while a feature has it there
	Bodies
};

struct Scene
{
	btISTWorld world;
	btBoxShape tableShape{btVector3(.5, .5, .5)}, lowerShape{btVector3(.5, .5, .5)}, upperShape{btVector3(.5, .5, .5)},
		boxShape{btVector3(1, .5, 1)};
	btSphereShape ballShape{btScalar(.5)};
	btStaticPlaneShape planeShape{btVector3(0, 1, 0), kBase.y() - 3};
	btISTAttachment table = world.attach(&tableShape, levelledTree()).value(), lower,
					upper = world.attach(&upperShape, levelledTree()).value();
	std::array<std::unique_ptr<btRigidBody>, Bodies> bodies;
	std::unique_ptr<btEnergyLaw> law;      ///< of `Lower` and `Upper`
	std::unique_ptr<btPaperLaw> paperLaw;  ///< of `Table` and `Lower`
	std::weak_ptr<const ist::InnerSphereTree> detached;
	std::map<std::string, std::function<void()>> eachStep;  ///< before it
	bool onlyPair = false, onlyRegion = false;              ///< that are watched
	bool hasPairCache = true;
	double accepted = 0, acceptedOfUpper = -1;           ///< force errors; negative: none of its own
	std::array<double, Bodies> upward{}, speedBefore{};  ///< impulse of the contacts while measured [N s]; and velocity before
	double kinetic = 0;                                  ///< largest kinetic energy so far [J]
	long allocations = 0;                                ///< in steps, while measured

	Scene()
	{
		attachLower(std::make_shared<const ist::InnerSphereTree>(*plainTree()));
		make(Table, tableShape, 0, 0, -.5);
		make(Plane, planeShape, 0, 0, 0);
		make(Box, boxShape, 0, 10, -.5);
		make(Lower, lowerShape, kMass, 0, .5);
		make(Upper, upperShape, kMass, 0, 1.5);
		make(OnPlane, lowerShape, kMass, 5, -2.5);
		make(OnBox, upperShape, kMass, 10, .5);
		make(Ball, ballShape, kMass, -5, -2.5);
		make(Extra, upperShape, kMass, -10, -2.5);
		bodies[Plane]->setWorldTransform(btTransform::getIdentity());
		for (int i = 0; i < Extra; ++i) world.bullet().addRigidBody(bodies[size_t(i)].get());
	}
	~Scene()
	{
		law.reset();
		paperLaw.reset();
		for (const auto& body : bodies)
			if (body->isInWorld()) world.bullet().removeRigidBody(body.get());
	}
	void make(Name name, btCollisionShape& shape, double mass, double x, double y)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape.calculateLocalInertia(btScalar(mass), inertia);
		bodies[name] = std::make_unique<btRigidBody>(btScalar(mass), nullptr, &shape, inertia);
		bodies[name]->setActivationState(DISABLE_DEACTIVATION);
		place(name, btTransform(btQuaternion::getIdentity(), kBase + btVector3(btScalar(x), btScalar(y), 0)));
	}
	void place(int name, const btTransform& pose)
	{
		btRigidBody& body = *bodies[size_t(name)];
		body.setWorldTransform(pose);
		body.setInterpolationWorldTransform(pose);
		for (const auto set : {&btRigidBody::setLinearVelocity, &btRigidBody::setAngularVelocity}) (body.*set)(btVector3(0, 0, 0));
		body.setInterpolationLinearVelocity(btVector3(0, 0, 0));
		body.setInterpolationAngularVelocity(btVector3(0, 0, 0));
		body.updateInertiaTensor();
		body.clearForces();
	}
	btRigidBody& body(int name) { return *bodies[size_t(name)]; }
	void attachLower(std::shared_ptr<const ist::InnerSphereTree> tree)
	{
		if (!lower.isAttached()) lower = world.attach(&lowerShape, std::move(tree)).value();
	}
	void detachLower()
	{
		const auto tree = world.registration().registry().find(&lowerShape);
		if (tree != coarseTree()) detached = tree;
		lower.detach();
	}
	void setPairCache(btOverlappingPairCache* cache)
	{
		hasPairCache = cache != nullptr;
		if (const auto refused = world.registration().setPairCache(cache)) ADD_FAILURE() << refused->message;
	}
	/// In a group of its own, Bullet's of what moves: it would put a kinematic body into that of static ones.
	void addUpper() { world.bullet().addRigidBody(&body(Upper), btBroadphaseProxy::DefaultFilter, btBroadphaseProxy::AllFilter); }
	void clean() { world.registration().cleanPairs(world.bullet().getPairCache()); }
	void cleanIfNothingDoes()
	{
		if (!hasPairCache) clean();
	}
	void cleanBody(int name)
	{
		if (btBroadphaseProxy* proxy = body(name).getBroadphaseHandle())
			world.bullet().getPairCache()->cleanProxyFromPairs(proxy, world.bullet().getDispatcher());
	}
	double height(int name) const { return double(bodies[size_t(name)]->getWorldTransform().getOrigin().y()); }
	bool moves(int name) const
	{
		const btRigidBody& body = *bodies[size_t(name)];
		return body.isInWorld() && !body.isStaticOrKinematicObject() && body.isActive();
	}

	void run(int steps)
	{
		for (int i = 0; i < steps; ++i)
		{
			if (i == steps - kMeasured) beginMeasuring();
			for (const auto& [name, act] : eachStep) act();
			const long before = allocationCount();
			if (const auto refused = world.step(kStep)) ADD_FAILURE() << refused->message;
			allocations += allocationCount() - before;
			addUpward();
			double energy = 0;
			for (int k = 0; k < Bodies; ++k)
				if (moves(k)) energy += 0.5 * kMass * double(body(k).getLinearVelocity().length2());
			kinetic = std::isfinite(energy) ? std::max(kinetic, energy) : energy;
		}
	}
	void beginMeasuring()
	{
		upward.fill(0);
		allocations = 0;
		for (int i = 0; i < Bodies; ++i) speedBefore[size_t(i)] = double(body(i).getLinearVelocity().y());
	}
	int nameOf(const btCollisionObject* object) const
	{
		for (int i = 0; i < Bodies; ++i)
			if (bodies[size_t(i)].get() == object) return i;
		return -1;
	}
	/// What all contacts of the last step gave to the bodies.
	void addUpward()
	{
		btDispatcher& dispatcher = *world.bullet().getDispatcher();
		for (int m = 0; m < dispatcher.getNumManifolds(); ++m)
		{
			const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
			const btISTContact* contact = world.contacts().find(&manifold);
			double onA = 0;
			if (contact && contact->patchCount > 0)
				for (int i = 0; i < contact->patchCount; ++i) onA += contact->impulses[i].force.y;
			else
				for (int i = 0; i < manifold.getNumContacts(); ++i)
				{
					const btManifoldPoint& p = manifold.getContactPoint(i);
					onA += double(p.m_appliedImpulse) * double(p.m_normalWorldOnB.y()) +
						double(p.m_appliedImpulseLateral1) * double(p.m_lateralFrictionDir1.y()) +
						double(p.m_appliedImpulseLateral2) * double(p.m_lateralFrictionDir2.y());
				}
			upward[size_t(nameOf(manifold.getBody0()))] += onA;
			upward[size_t(nameOf(manifold.getBody1()))] -= onA;
		}
		if (paperLaw) upward[Lower] += kStep * paperLaw->contact(0).onB.force.y;
		for (int i = 0; law && i < law->pairCount() && bodies[Upper]->isInWorld(); ++i)
		{
			upward[Lower] += kStep * law->contact(i).onA.force.y;
			upward[Upper] += kStep * law->contact(i).onB.force.y;
		}
	}
};
}  // namespace feature_pairs
