// SPDX-License-Identifier: Zlib
// Volumetric contact in a world of one's own, with Bullet's own solver.
#include "Settled.h"

#include <BulletISTCollision/btBulletISTCollisionCommon.h>

int main()
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
	btISTRegistration registration = btISTCollisionAlgorithm::registerAlgorithm(&dispatcher);

	CubeOnPlane scene(world);
	const ist::Result<btISTAttachment> attachment = registration.registry().attach(&scene.cubeShape, unitCube());
	if (!attachment) return 1;
	for (int i = 0; i < 120; ++i) world.stepSimulation(btScalar(1.0 / 60), 0);
	return verdict(scene.cube, registration.store().contacts().size());
}
