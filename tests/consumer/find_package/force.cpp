// SPDX-License-Identifier: Zlib
// The same with the volumetric solver.
#include "Settled.h"

#include <BulletHapticForce/btBulletHapticForceCommon.h>

int main()
{
	btISTWorld world;
	CubeOnPlane scene(world.bullet());
	const ist::Result<btISTAttachment> attachment = world.attach(&scene.cubeShape, unitCube());
	if (!attachment) return 1;
	for (int i = 0; i < 120; ++i) world.bullet().stepSimulation(btScalar(1.0 / 60), 0);
	return verdict(scene.cube, world.contacts().contacts().size());
}
