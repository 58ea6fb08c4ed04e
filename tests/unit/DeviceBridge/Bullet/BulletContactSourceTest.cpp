// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletContactSource.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/KeptTree.h"

#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <vector>

using namespace devicebridge;
using ist::Vec3;

namespace
{
constexpr double kStep = 1e-3;
constexpr bool kDouble = sizeof(btScalar) == 8;
constexpr double kRadius = 0.02, kToolMass = 0.1, kBodyMass = 0.3;

std::shared_ptr<const ist::InnerSphereTree> ballTree()
{
	static const auto tree = keptTree(ist::makeSphereMesh(kRadius, 3), "ball_20mm.ist");
	return tree;
}

Vec3 toVec3(const btVector3& v) { return {double(v.x()), double(v.y()), double(v.z())}; }
btVector3 toBullet(const Vec3& v) { return btVector3(btScalar(v.x), btScalar(v.y), btScalar(v.z)); }

/// A ball on the coupling and, optionally, a second ball that floats. Both have the same inertia about all axes.
struct Rig
{
	btISTWorld world;
	btSphereShape shape{btScalar(kRadius)};
	btISTAttachment attachment = std::move(world.attach(&shape, ballTree())).value();
	std::vector<std::unique_ptr<btRigidBody>> bodies;
	btRigidBody* tool;

	explicit Rig(const Vec3& at, const Vec3& gravity = {}) { world.setGravity(toBullet(gravity)), tool = add(kToolMass, at); }
	~Rig()
	{
		for (auto& body : bodies) world.bullet().removeRigidBody(body.get());
	}
	btRigidBody* add(double mass, const Vec3& at)
	{
		const btScalar inertia = btScalar(0.4 * mass * kRadius * kRadius);
		bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, &shape, btVector3(inertia, inertia, inertia)));
		btRigidBody* body = bodies.back().get();
		const btTransform pose(btQuaternion::getIdentity(), toBullet(at));
		body->setWorldTransform(pose);
		body->setInterpolationWorldTransform(pose);
		body->setFriction(btScalar(0.7));
		EXPECT_FALSE(world.materials().set(body, {2e7, -1}));
		world.bullet().addRigidBody(body);
		return body;
	}
};

BulletToolSettings settings(const ist::Pose& X_BW = {})
{
	BulletToolSettings s;
	s.gains = {1000, 0.2, 2, 1e-4, 100, 10};
	s.X_BW = X_BW;
	return s;
}

ist::Pose randomPose(std::mt19937_64& random, double reach)
{
	std::uniform_real_distribution<double> u(-1, 1);
	return {rotationMatrix(ist::quaternionFromRotationVector(Vec3{2 * u(random), 2 * u(random), 2 * u(random)})),
		{reach * u(random), reach * u(random), reach * u(random)}};
}

DeviceState handAt(const Vec3& position, const Vec3& turn = {}, const ist::Twist& twist = {})
{
	DeviceState hand;
	hand.X_WH = {rotationMatrix(ist::quaternionFromRotationVector(turn)), position};
	hand.twist = twist;
	return hand;
}

void advance(BulletContactSource& source, const DeviceState& hand, ToolStep& step)
{
	step.contactCount = 0;
	step.overlapVolume = 0;
	step.pairs = 0;
	source.advance(kStep, hand, step);
}

struct Momentum
{
	Vec3 linear, angular;  // momentum, and angular momentum about the origin of World
};

Momentum momentumOf(const btRigidBody& body)
{
	const double mass = 1 / double(body.getInvMass()), inertia = 1 / double(body.getInvInertiaDiagLocal().x());
	const Vec3 p = mass * toVec3(body.getLinearVelocity());
	return {p, inertia * toVec3(body.getAngularVelocity()) + cross(toVec3(body.getWorldTransform().getOrigin()), p)};
}
}  // namespace

// At constant velocity no force remains, so K (x_h - x - h v) = 0. The tool ends each step where the hand was at its beginning.
TEST(BulletContactSource, ToolFollowsAHandInFreeSpace)
{
	std::mt19937_64 random(3);
	for (const double reach : {0.0, 1.0, 1000.0})
	{
		if (reach > 10 && !kDouble) continue;  // a float has a resolution of 0.06 mm there
		const ist::Pose X_BW = randomPose(random, reach);
		Rig rig(X_BW.translation);
		BulletContactSource source(rig.world, *rig.tool, settings(X_BW));
		const ist::Twist twist{{0.05, -0.02, 0.03}, {0, 0.6, 0}};
		ToolStep step;
		ist::Pose hand;
		// The tool begins along Bullet's axes, and the coupling rotates it.
		for (int i = 0; i <= 4500; ++i)
		{
			const DeviceState state = handAt(i * kStep * twist.linear, i * kStep * twist.angular, twist);
			hand = state.X_WH;
			advance(source, state, step);
		}
		const double tolerance = kDouble ? 1e-9 : 1e-6;
		EXPECT_LT(distance(step.tool.X_WT.translation, hand.translation), tolerance) << reach;
		EXPECT_LT(norm(step.tool.twist.linear - twist.linear), 100 * tolerance) << reach;
		const Vec3 left = rotationVector(ist::quaternion(step.tool.X_WT.rotation * transpose(hand.rotation)));
		EXPECT_LT(norm(left), 100 * tolerance) << reach;
		EXPECT_LT(norm(step.coupling.force), 1e4 * tolerance) << reach;
		EXPECT_EQ(step.contactCount, 0);
	}
}

TEST(BulletContactSource, TheHandCarriesTheToolUnlessGravityIsAskedFor)
{
	for (const bool gravity : {false, true})
	{
		Rig rig({}, {0, -9.81, 0});
		BulletToolSettings s = settings();
		s.gravity = gravity;
		BulletContactSource source(rig.world, *rig.tool, s);
		ToolStep step;
		for (int i = 0; i < 4000; ++i) advance(source, handAt({}), step);
		// F = K (x_h - x) / (1 + (h B + h^2 K) / m) carries the weight.
		const double softening = 1 + (kStep * s.gains.damping + kStep * kStep * s.gains.stiffness) / kToolMass;
		const double sag = gravity ? kToolMass * 9.81 * softening / s.gains.stiffness : 0;
		EXPECT_NEAR(step.tool.X_WT.translation.y, -sag, 1e-6);
		EXPECT_NEAR(step.coupling.force.y, gravity ? kToolMass * 9.81 : 0, 1e-4);
		EXPECT_TRUE(rig.tool->isActive());
	}
}

// The world gains the momentum that the coupling gives. The tool gains what the coupling and its contacts give. Both hold for linear and
// angular momentum.
TEST(BulletContactSource, ActionEqualsReactionWhileTheToolPushesABody)
{
	std::mt19937_64 random(7);
	for (const bool toolFirst : {true, false})
	{
		const ist::Pose X_BW = randomPose(random, 0.5);
		Rig rig(X_BW.translation);
		btRigidBody* body = rig.add(kBodyMass, X_BW * Vec3{0.045, 0.008, -0.005});
		if (!toolFirst)  // the other order in Bullet's pair, and therefore the other sign
		{
			rig.world.bullet().removeRigidBody(rig.tool);
			rig.world.bullet().addRigidBody(rig.tool);
		}
		BulletContactSource source(rig.world, *rig.tool, settings(X_BW));
		Momentum given, onTool;
		double size = 0, spin = 0;
		int touching = 0;
		ToolStep step;
		for (int i = 0; i < 400; ++i)
		{
			const Vec3 origin = toVec3(rig.tool->getWorldTransform().getOrigin());
			advance(source, handAt({0.1 * i * kStep, 0, 0}, {0.5 * i * kStep, 0, 0}, {{0.1, 0, 0}, {0.5, 0, 0}}), step);
			const auto addTo = [&](Momentum& sum, const ist::Wrench& inW) {
				const Vec3 f = kStep * (X_BW.rotation * inW.force);
				sum.linear += f;
				sum.angular += kStep * (X_BW.rotation * inW.torque) + cross(origin, f);
				size += norm(f);
				spin += norm(kStep * inW.torque) + norm(cross(origin, f));
			};
			addTo(given, step.coupling);
			addTo(onTool, step.coupling);
			for (int c = 0; c < step.contactCount; ++c)
			{
				addTo(onTool, step.contacts[c].onTool);
				EXPECT_EQ(step.contacts[c].other, body);
				EXPECT_LT(step.contacts[c].normal.x, 0);
			}
			touching += step.contactCount;
		}
		const Momentum tool = momentumOf(*rig.tool), pushed = momentumOf(*body);
		const double tolerance = kDouble ? 1e-11 : 1e-5;
		EXPECT_GT(touching, 20);
		EXPECT_GT(norm(pushed.linear), 0.02);
		EXPECT_LT(norm(tool.linear + pushed.linear - given.linear), tolerance * size);
		EXPECT_LT(norm(tool.linear - onTool.linear), tolerance * size);
		EXPECT_LT(norm(tool.angular + pushed.angular - given.angular), tolerance * spin);
		EXPECT_LT(norm(tool.angular - onTool.angular), tolerance * spin);
	}
}

TEST(BulletContactSource, OverlapIsTheLensOfTwoBalls)
{
	Rig rig({});
	const double apart = 1.7 * kRadius;
	rig.add(kBodyMass, {apart, 0, 0});
	BulletContactSource source(rig.world, *rig.tool, settings());
	ToolStep step;
	advance(source, handAt({}), step);
	// Overlap volume of equal balls: pi (4 r + d) (2 r - d)^2 / 12.
	const double lens = 3.14159265358979 * (4 * kRadius + apart) * (2 * kRadius - apart) * (2 * kRadius - apart) / 12;
	ASSERT_EQ(step.contactCount, 1);
	EXPECT_NEAR(step.overlapVolume, lens, 0.1 * lens);  // tolerance for 300 spheres, and for a mesh slightly smaller than the ball
	EXPECT_EQ(step.overlapVolume, step.contacts[0].volume);
	EXPECT_GT(step.pairs, 0);
	EXPECT_GT(step.queryMicroseconds, 0);
	EXPECT_LT(step.contacts[0].onTool.force.x, 0);
	EXPECT_NEAR(step.contacts[0].normal.x, -1, 0.05);
	EXPECT_NEAR(step.contacts[0].point.x, apart / 2, 0.1 * kRadius);
}

TEST(BulletContactSource, AHandThatIsNotFiniteDoesNotPull)
{
	const double nan = std::nan(""), infinite = std::numeric_limits<double>::infinity();
	std::vector<DeviceState> hands(4, handAt({0.1, 0.2, 0.3}));
	hands[0].X_WH.translation.y = nan;
	hands[1].twist.angular.z = infinite;
	hands[2].X_WH.rotation.m[1][1] = nan;
	hands[3].X_WH.rotation = ist::zeroMat3();
	for (const DeviceState& hand : hands)
	{
		Rig rig({});
		rig.tool->setLinearVelocity(btVector3(0, btScalar(0.25), 0));
		BulletContactSource source(rig.world, *rig.tool, settings());
		ToolStep step;
		step.coupling.force = {1, 2, 3};
		for (int i = 0; i < 8; ++i) advance(source, hand, step);
		EXPECT_EQ(norm(step.coupling.force) + norm(step.coupling.torque), 0);
		EXPECT_EQ(step.tool.twist.linear.y, 0.25);
		EXPECT_NEAR(step.tool.X_WT.translation.y, 8 * kStep * 0.25, 1e-8);
	}
}

TEST(BulletContactSource, ATickDoesNotAllocateAfterWarmUp)
{
	Rig rig({}, {0, -9.81, 0});
	btRigidBody* body = rig.add(kBodyMass, {0.038, 0, 0});
	body->setLinearFactor(btVector3(0, 0, 0));
	BulletContactSource source(rig.world, *rig.tool, settings());
	ToolStep step;
	const auto press = [&](int i) { advance(source, handAt({0.004 + 0.001 * std::sin(0.1 * i), 0, 0}), step); };
	for (int i = 0; i < 100; ++i) press(i);
	ASSERT_EQ(step.contactCount, 1);
	const long before = allocationCount();
	for (int i = 0; i < 300; ++i) press(i);
	EXPECT_EQ(allocationCount(), before);
	EXPECT_EQ(step.contactCount, 1);
}
