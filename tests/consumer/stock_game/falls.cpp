// SPDX-License-Identifier: Zlib
// The game's own test of its physics: a cube that falls on the floor comes to rest.
#include "../find_package/Settled.h"

#include <TestSupport/TestWorld.h>

int main()
{
	ist::test::TestWorld world(500);
	world.addFloor();
	const btRigidBody& cube = world.addMesh(ist::makeBoxMesh({0.5, 0.5, 0.5}), 1, ist::test::at(0, 0.55, 0));
	world.run(2);
	return verdict(cube, world.world().contacts().contacts().size());
}
