// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Bullet/BulletContactSource.h"
#include "tests/unit/DeviceBridge/Bullet/DecoupledRig.h"

#include <memory>
#include <stdexcept>
#include <utility>

namespace devicebridge
{
using ist::Vec3;

constexpr double kSpring = 1000, kTick = 1e-3;  // [N/m, s]

inline BulletDecoupledSettings staticSettings()
{
	BulletDecoupledSettings settings = handSettings();
	settings.gains.stiffness = kSpring;
	settings.gains.isStatic = true;
	return settings;
}

inline Vec3 contactForce(const ToolStep& step)
{
	Vec3 sum;
	for (int i = 0; i < step.contactCount; ++i) sum += step.contacts[i].onTool.force;
	return sum;
}

/// The same ball and hand, with the world stepped in the tick.
struct OneThread
{
	btISTWorld world;
	btSphereShape shape{btScalar(kBallRadius)};
	btStaticPlaneShape planeShape{btVector3(0, 1, 0), 0};
	btISTAttachment attached = std::move(world.attach(&shape, ballTree())).value();
	btRigidBody tool, floor;
	std::unique_ptr<BulletContactSource> source;
	DeviceState hand;
	ToolStep step;

	explicit OneThread(const Vec3& at, bool gravity = false, double softContact = 1)
		: tool(Hand::info(shape, at)),
		  floor(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &planeShape))
	{
		world.setGravity(btVector3(0, btScalar(-9.81), 0));
		world.bullet().addRigidBody(&tool);
		world.bullet().addRigidBody(&floor);
		for (btRigidBody* body : {&tool, &floor})
			if (world.materials().set(body, {2e7, softContact > 1 ? 0.0 : -1.0})) throw std::runtime_error("material refused");
		if (softContact > 1) floor.setFriction(0);
		BulletToolSettings settings;
		settings.gains = staticSettings().gains;
		settings.gains.softContact = softContact;
		settings.gravity = gravity;
		source = std::make_unique<BulletContactSource>(world, tool, settings);
		hand.X_WH.translation = at;
	}
	~OneThread()
	{
		world.bullet().removeRigidBody(&tool);
		world.bullet().removeRigidBody(&floor);
	}
	void tick(const Vec3& velocity)
	{
		hand.X_WH.translation += kTick * velocity;
		hand.twist.linear = velocity;
		step.contactCount = 0;
		step.overlapVolume = 0;
		source->advance(kTick, hand, step);
	}
};
}  // namespace devicebridge
