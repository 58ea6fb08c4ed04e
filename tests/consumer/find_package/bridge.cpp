// SPDX-License-Identifier: Zlib
// The cube as the tool of a hand that stays where the cube touches the plane: each tick is a step of the world.
#include "Settled.h"

#include <DeviceBridge/Bullet/BulletContactSource.h>

int main()
{
	btISTWorld world;
	CubeOnPlane scene(world.bullet());
	const ist::Result<btISTAttachment> attachment = world.attach(&scene.cubeShape, unitCube());
	if (!attachment) return 1;
	devicebridge::BulletToolSettings settings;
	settings.gains = {200, 20, 20, 2, 50, 10};
	devicebridge::BulletContactSource source(world, scene.cube, settings);
	devicebridge::DeviceState hand;
	hand.X_WH.translation = {0, 0.499, 0};
	devicebridge::ToolStep step;
	for (int i = 0; i < 1000; ++i) source.advance(1e-3, hand, step);
	return verdict(scene.cube, world.contacts().contacts().size());
}
