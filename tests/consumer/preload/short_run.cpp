// SPDX-License-Identifier: Zlib
// A game with one ring that ends after its first step: short_run [exit|return|kill|term|abort].
#include "ring.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>

#include <csignal>
#include <cstdlib>
#include <cstring>

int main(int argc, char** argv)
{
	const auto ends = [&](const char* way) { return std::strcmp(argc > 1 ? argv[1] : "return", way) == 0; };
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
	btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
	btTriangleMesh* const triangles = makeRing();
	btGImpactMeshShape ring(triangles);
	ring.updateBound();
	btRigidBody body(1, nullptr, &ring, btVector3(1, 1, 1));
	world.addRigidBody(&body);
	world.stepSimulation(btScalar(1.0 / 60));
	if (ends("exit")) std::exit(0);
	if (ends("kill")) std::raise(SIGKILL);
	if (ends("term")) std::raise(SIGTERM);
	if (ends("abort")) std::abort();
	world.removeRigidBody(&body);
	delete triangles;
	return 0;
}
