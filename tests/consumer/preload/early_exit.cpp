// SPDX-License-Identifier: Zlib
// A game that ends in one thread after so many milliseconds (its argument) while another still steps its world, in which a new ring takes
// the place of the last in every step.
#include "ring.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>

#include <chrono>
#include <cstdlib>
#include <thread>

namespace
{
[[noreturn]] void play()
{
	auto* configuration = new btDefaultCollisionConfiguration;
	auto* dispatcher = new btCollisionDispatcher(configuration);
	auto* world = new btDiscreteDynamicsWorld(dispatcher, new btDbvtBroadphase, new btSequentialImpulseConstraintSolver, configuration);
	btGImpactCollisionAlgorithm::registerAlgorithm(dispatcher);
	btTriangleMesh* triangles = makeRing();
	btRigidBody* last = nullptr;
	for (;;)
	{
		auto* ring = new btGImpactMeshShape(triangles);  // never where the last one is
		ring->updateBound();
		auto* body = new btRigidBody(1, nullptr, ring, btVector3(1, 1, 1));
		world->addRigidBody(body);
		if (last)
		{
			world->removeRigidBody(last);
			delete last->getCollisionShape();
			delete last;
		}
		last = body;
		world->stepSimulation(btScalar(1.0 / 60));
	}
}
}  // namespace

int main(int argc, char** argv)
{
	std::thread(play).detach();
	std::this_thread::sleep_for(std::chrono::milliseconds(argc > 1 ? std::atoi(argv[1]) : 0));
	std::exit(0);
}
