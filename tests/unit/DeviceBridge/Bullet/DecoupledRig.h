// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "DeviceBridge/Bullet/BulletContactSource.h"
#include "DeviceBridge/Bullet/BulletWorldCoupling.h"
#include "tests/unit/KeptTree.h"

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btConvexHullShape.h"
#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <functional>
#include <memory>
#include <stdexcept>
#include <vector>

namespace devicebridge
{
inline ist::Vec3 vec3(const btVector3& v) { return {double(v.x()), double(v.y()), double(v.z())}; }
inline btVector3 bullet(const ist::Vec3& v) { return btVector3(btScalar(v.x), btScalar(v.y), btScalar(v.z)); }

constexpr double kBallRadius = 0.02, kBoxHalf = 0.02, kDecoupledToolMass = 0.1;
constexpr std::int64_t kTickPeriod = 1'000'000;

inline const auto& ballTree()
{
	static const auto tree = keptTree(ist::makeSphereMesh(kBallRadius, 3), "ball_20mm.ist");
	return tree;
}
inline const auto& boxTree()
{
	static const auto tree = keptTree(ist::makeBoxMesh({kBoxHalf, kBoxHalf, kBoxHalf}), "box_40mm.ist");
	return tree;
}

constexpr ContactThreading kTopologies[] = {ContactThreading::InHapticThread, ContactThreading::OwnThread, ContactThreading::InWorldThread};

inline const char* nameOf(ContactThreading t)
{
	return t == ContactThreading::InHapticThread ? "in the tick" : t == ContactThreading::OwnThread ? "in its own thread" : "in the world";
}

inline btTransform placed(double x, double y, double z, const btQuaternion& q = btQuaternion::getIdentity())
{
	return btTransform(q, bullet({x, y, z}));
}

/// What a hand says of a body that it does not feel; null if it feels it.
inline const BulletUnfeltBody* findUnfelt(const BulletWorldCoupling& coupling, const btCollisionObject* body)
{
	for (const BulletUnfeltBody& unfelt : coupling.unfelt())
		if (unfelt.body == body) return &unfelt;
	return nullptr;
}

/// A hand whose motion the test prescribes.
struct Hand
{
	btRigidBody body;
	BulletDecoupledSource source;
	ToolStep step;
	DeviceState state;
	std::function<ist::Twist(double)> script;  ///< twist at a time [s]
	ist::Vec3 coupled;                         ///< sum of the coupling's impulses so far [N s]
	double largest = 0;                        ///< largest force of the coupling [N]

	Hand(btCollisionShape& shape, std::shared_ptr<const ist::InnerSphereTree> tree, Clock& clock, const ist::Vec3& at,
		const BulletDecoupledSettings& settings)
		: body(info(shape, at)),
		  source(body, std::move(tree), clock, settings)
	{
		state.X_WH.translation = at;
	}
	/// A tool with the parts of its shape.
	Hand(btISTWorld& world, btCollisionShape& shape, Clock& clock, const ist::Vec3& at, const BulletDecoupledSettings& settings)
		: body(info(shape, at)),
		  source(world, body, clock, settings)
	{
		state.X_WH.translation = at;
	}
	static btRigidBody::btRigidBodyConstructionInfo info(btCollisionShape& shape, const ist::Vec3& at)
	{
		const btScalar inertia = btScalar(0.4 * kDecoupledToolMass * kBallRadius * kBallRadius);
		btRigidBody::btRigidBodyConstructionInfo made(btScalar(kDecoupledToolMass), nullptr, &shape, btVector3(inertia, inertia, inertia));
		made.m_startWorldTransform = btTransform(btQuaternion::getIdentity(), bullet(at));
		made.m_friction = btScalar(0.8);
		return made;
	}
	void tick(double time)
	{
		constexpr double h = 1e-9 * kTickPeriod;
		state.twist = script ? script(time) : ist::Twist();
		state.X_WH.translation += h * state.twist.linear;
		step.contactCount = 0;
		step.overlapVolume = 0;
		step.pairs = 0;
		source.advance(h, state, step);
		coupled += h * step.coupling.force;
		largest = std::max(largest, norm(step.coupling.force));
	}
	ist::Vec3 momentum() const { return kDecoupledToolMass * source.toolState().twist.linear; }
};

inline BulletDecoupledSettings handSettings()
{
	BulletDecoupledSettings settings;
	settings.gains = {1000, 0.2, 2, 1e-4, 100, 10};
	return settings;
}

/// Forces of the coupling on a tool that a world leads in one thread with the gains of handSettings(), one for each tick of 1 ms. The hand
/// begins at `start` and moves by the twists of `script`, which gets the time [s].
inline std::vector<ist::Vec3> forcesInOneThread(
	btISTWorld& world, btRigidBody& tool, const ist::Vec3& start, const std::function<ist::Twist(double)>& script, int ticks)
{
	BulletToolSettings settings;
	settings.gains = handSettings().gains;
	BulletContactSource source(world, tool, settings);
	DeviceState state;
	state.X_WH.translation = start;
	ToolStep step;
	std::vector<ist::Vec3> forces;
	for (int i = 0; i < ticks; ++i)
	{
		state.twist = script(1e-3 * (i + 1));
		state.X_WH.translation += 1e-3 * state.twist.linear;
		step.contactCount = 0, step.overlapVolume = 0, step.pairs = 0;
		source.advance(1e-3, state, step);
		forces.push_back(step.coupling.force);
	}
	return forces;
}

/// A world that its own clock steps between the ticks of the hands, all in virtual time.
struct DecoupledRig
{
	btISTWorld world;
	btSphereShape ballShape{btScalar(kBallRadius)};
	btBoxShape boxShape{btVector3(btScalar(kBoxHalf), btScalar(kBoxHalf), btScalar(kBoxHalf))};
	btStaticPlaneShape planeShape{btVector3(0, 1, 0), 0};
	btISTAttachment ballTreeAttached = std::move(world.attach(&ballShape, ballTree())).value();
	btISTAttachment boxTreeAttached = std::move(world.attach(&boxShape, boxTree())).value();
	BulletWorldCoupling coupling{world};
	VirtualClock clock;
	std::vector<std::unique_ptr<btRigidBody>> bodies;
	std::vector<std::unique_ptr<Hand>> hands;
	double period;
	std::int64_t ticks = 0, worldSteps = 0;
	bool shown = false;
	bool worldRuns = true, sleeping = false;
	bool serving = true;  ///< whether the test's own thread answers the questions of ContactThreading::OwnThread
	std::function<void()> afterTick, afterWorldStep;

	explicit DecoupledRig(double rate, const ist::Vec3& gravity = {}) : period(1 / rate) { world.setGravity(bullet(gravity)); }
	~DecoupledRig()
	{
		for (auto& body : bodies) world.bullet().removeRigidBody(body.get());
	}

	btRigidBody* add(btCollisionShape& shape, double mass, const ist::Vec3& at, double friction = 0.8, double stiffness = 2e7)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape.calculateLocalInertia(btScalar(mass), inertia);
		bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, &shape, inertia));
		btRigidBody* body = bodies.back().get();
		const btTransform pose(btQuaternion::getIdentity(), bullet(at));
		body->setWorldTransform(pose);
		body->setInterpolationWorldTransform(pose);
		body->setFriction(btScalar(friction));
		if (const auto refused = world.materials().set(body, {stiffness, -1})) throw std::runtime_error(refused->message);
		if (!sleeping) body->forceActivationState(DISABLE_DEACTIVATION);
		world.bullet().addRigidBody(body);
		return body;
	}
	btRigidBody* addBall(double mass, const ist::Vec3& at) { return add(ballShape, mass, at); }
	btRigidBody* addBox(double mass, const ist::Vec3& at) { return add(boxShape, mass, at); }
	btRigidBody* addPlane() { return add(planeShape, 0, {}); }

	Hand& addHand(const ist::Vec3& at, const BulletDecoupledSettings& settings = handSettings(), bool boxTool = false)
	{
		if (boxTool) hands.push_back(std::make_unique<Hand>(boxShape, boxTree(), clock, at, settings));
		else hands.push_back(std::make_unique<Hand>(ballShape, ballTree(), clock, at, settings));
		if (const auto refused = world.materials().set(&hands.back()->body, {2e7, -1})) throw std::runtime_error(refused->message);
		coupling.add(hands.back()->source);
		return *hands.back();
	}

	double time() const { return 1e-9 * static_cast<double>(clock.now()); }
	/// Runs ticks of the hands, with the steps of the world that fall between them.
	void run(double seconds)
	{
		if (!shown) coupling.show(period);
		shown = true;
		const auto end = ticks + static_cast<std::int64_t>(seconds * 1e3 + 0.5);
		while (ticks < end)
		{
			while (worldRuns && static_cast<double>(worldSteps + 1) * period <= time() + 1e-9) stepWorld();
			clock.sleepUntil(++ticks * kTickPeriod);
			for (auto& hand : hands)
			{
				hand->tick(time());
				if (serving && topologyNeedsServing(*hand)) hand->source.serveContacts();
			}
			if (afterTick) afterTick();
		}
	}
	void stepWorld()
	{
		coupling.step(period);
		++worldSteps;
		if (afterWorldStep) afterWorldStep();
	}
	static bool topologyNeedsServing(const Hand& hand) { return hand.source.topology() == ContactThreading::OwnThread; }
};
}  // namespace devicebridge
