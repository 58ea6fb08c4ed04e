// SPDX-License-Identifier: Zlib
// A game that keeps everything on the heap and clears up as Bullet's examples do: bodies, shapes, world, solver, broad phase, dispatcher.
// Boxes on a plane and a hinge; with `--gimpact` two rings, too, one of which goes halfway, and the world goes last; with `--threaded` they
// come late, into a world whose dispatcher may have several threads. Prints where every body is after each frame, exactly.
#include "ring.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <LinearMath/btThreads.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <vector>

namespace
{
btRigidBody* add(btDynamicsWorld& world, std::vector<btRigidBody*>& bodies, btCollisionShape* shape, double mass, const btVector3& place)
{
	btVector3 inertia(0, 0, 0);
	if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
	auto* body = new btRigidBody(btScalar(mass), nullptr, shape, inertia);
	body->setWorldTransform(btTransform(btQuaternion::getIdentity(), place));
	world.addRigidBody(body);
	bodies.push_back(body);
	return body;
}
}  // namespace

int main(int argc, char** argv)
{
	const bool threaded = argc > 1 && std::strcmp(argv[1], "--threaded") == 0;
	const bool gimpact = threaded || (argc > 1 && std::strcmp(argv[1], "--gimpact") == 0);
	const int ringsCome = threaded ? 60 : 0, ringGoes = 120;  // frames
	if (threaded) btSetTaskScheduler(btGetSequentialTaskScheduler());
	auto* configuration = new btDefaultCollisionConfiguration;
	btCollisionDispatcher* dispatcher = threaded ? new btCollisionDispatcherMt(configuration) : new btCollisionDispatcher(configuration);
	auto* broadphase = new btDbvtBroadphase;
	auto* solver = new btSequentialImpulseConstraintSolver;
	btDynamicsWorld* world = new btDiscreteDynamicsWorld(dispatcher, broadphase, solver, configuration);
	auto* plane = new btStaticPlaneShape(btVector3(0, 1, 0), 0);
	auto* box = new btBoxShape(btVector3(btScalar(.4), btScalar(.3), btScalar(.5)));
	std::vector<btRigidBody*> bodies;
	add(*world, bodies, plane, 0, btVector3(0, 0, 0));
	for (int i = 0; i < 8; ++i) add(*world, bodies, box, 1, btVector3(btScalar(0.03 * i), btScalar(0.4 + 0.7 * i), btScalar(0.02 * i)));
	auto* hinge = new btHingeConstraint(
		*bodies[7], *bodies[8], btVector3(0, btScalar(.35), 0), btVector3(0, btScalar(-.35), 0), btVector3(0, 0, 1), btVector3(0, 0, 1));
	world->addConstraint(hinge);
	btTriangleMesh* triangles = nullptr;
	btGImpactMeshShape* ring = nullptr;
	const auto addRings = [&] {
		btGImpactCollisionAlgorithm::registerAlgorithm(dispatcher);
		triangles = makeRing();
		ring = new btGImpactMeshShape(triangles);
		ring->updateBound();
		for (int i = 0; i < 2; ++i) add(*world, bodies, ring, 2, btVector3(-3, btScalar(0.3 + 0.6 * i), btScalar(0.05 * i)));
	};
	bool sound = true;
	for (int frame = 0; frame < 240; ++frame)
	{
		if (gimpact && frame == ringsCome) addRings();
		if (gimpact && frame == ringGoes)
		{
			world->removeRigidBody(bodies.back());
			delete bodies.back();
			bodies.pop_back();
		}
		world->stepSimulation(btScalar(1.0 / 60), 2, btScalar(1.0 / 120));
		for (const btRigidBody* body : bodies)
		{
			const btVector3 p = body->getWorldTransform().getOrigin();
			std::printf("%a %a %a\n", double(p.x()), double(p.y()), double(p.z()));
			sound = sound && std::isfinite(double(p.length2())) && p.y() > btScalar(-0.1);
		}
	}
	world->removeConstraint(hinge);
	delete hinge;
	for (btRigidBody* body : bodies)
	{
		world->removeRigidBody(body);
		delete body;
	}
	delete ring;
	delete triangles;
	delete box;
	delete plane;
	// An empty world asks none of them.
	const bool worldFirst = !gimpact || threaded;
	if (worldFirst) delete world;
	delete solver;
	delete broadphase;
	delete dispatcher;
	if (!worldFirst) delete world;
	delete configuration;
	return sound ? 0 : 1;
}
