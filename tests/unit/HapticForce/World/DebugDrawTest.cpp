// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/KeptTree.h"

#include <LinearMath/btIDebugDraw.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace
{
constexpr double kHalf = 0.05, kMass = 2, kGravity = 9.81;

/// Records what is drawn, without memory of its own.
struct Recorder : btIDebugDraw
{
	int mode = DBG_DrawWireframe;
	int lines = 0, grey = 0, spheres = 0, texts = 0;
	double arrow = 0;    ///< sum of the lengths of the blue lines upward [m]
	double reddest = 0;  ///< largest share of red where green is less
	double outside = 0;  ///< largest distance of a sphere's centre from the middle of the box, per axis [m]
	double newton = 0, millimetres = 0;

	using btIDebugDraw::drawLine;
	using btIDebugDraw::drawSphere;
	void drawLine(const btVector3& from, const btVector3& to, const btVector3& colour) override
	{
		++lines;
		if (colour.x() == colour.y() && colour.y() == colour.z()) ++grey;
		else if (colour.z() > 0) arrow += double(to.y() - from.y());
		else if (colour.y() < colour.x()) reddest = std::max(reddest, double(colour.x() - colour.y()));
	}
	void drawSphere(const btVector3& p, btScalar, const btVector3&) override
	{
		++spheres;
		for (int i = 0; i < 3; ++i) outside = std::max(outside, std::abs(double(p[i]) - (i == 1 ? kHalf : 0)));
	}
	void draw3dText(const btVector3&, const char* text) override
	{
		texts += std::sscanf(text, "%lf N, %lf mm", &newton, &millimetres) == 2;
	}
	void drawContactPoint(const btVector3&, const btVector3&, btScalar, int, const btVector3&) override {}
	void reportErrorWarning(const char*) override {}
	void setDebugMode(int m) override { mode = m; }
	int getDebugMode() const override { return mode; }
};

/// A box with a tree that rests on a plane, and beside it a box of Bullet's on one of Bullet's.
struct Scene
{
	btBoxShape box{btVector3(btScalar(kHalf), btScalar(kHalf), btScalar(kHalf))}, plain{box};
	btStaticPlaneShape plane{btVector3(0, 1, 0), 0};
	btISTWorld world;
	std::shared_ptr<const ist::InnerSphereTree> tree = keptTree(ist::makeBoxMesh({kHalf, kHalf, kHalf}), "debug_box.ist");
	btISTAttachment attached = std::move(world.attach(&box, tree)).value();
	btRigidBody floor{0, nullptr, &plane}, body{info(box)}, stock{info(plain)};

	static btRigidBody::btRigidBodyConstructionInfo info(btCollisionShape& shape)
	{
		btVector3 inertia;
		shape.calculateLocalInertia(btScalar(kMass), inertia);
		return {btScalar(kMass), nullptr, &shape, inertia};
	}
	Scene()
	{
		world.setLog([](const std::string&) {});
		place(body, 0), place(stock, 1);
		for (btRigidBody* each : {&floor, &body, &stock}) world.bullet().addRigidBody(each);
		for (int i = 0; i < 480; ++i) world.step(1.0 / 240);
	}
	~Scene()
	{
		for (btRigidBody* each : {&floor, &body, &stock}) world.bullet().removeRigidBody(each);
	}
	static void place(btRigidBody& each, double x)
	{
		each.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(x), btScalar(kHalf), 0)));
		each.forceActivationState(DISABLE_DEACTIVATION);
	}
};
}  // namespace

// The box rests, so its arrows must add up to its weight.
TEST(DebugDraw, ArrowsAreTheForcesAndBulletsContactIsGrey)
{
	Scene scene;
	Recorder drawn;
	btISTDebugDraw what;
	what.metresPerNewton = 0.01;
	what.text = false;
	scene.world.debugDraw(drawn, what);
	EXPECT_NEAR(drawn.arrow / what.metresPerNewton, kMass * kGravity, 0.02 * kMass * kGravity);
	EXPECT_GE(drawn.grey, 3) << "the points of Bullet's own box on the plane";
	EXPECT_EQ(drawn.reddest, 0) << "it rests, so it is not deep";
	EXPECT_EQ(drawn.spheres + drawn.texts, 0);
	Recorder without;
	what.stock = what.pairs = what.patches = false;
	scene.world.debugDraw(without, what);
	EXPECT_EQ(without.lines, 0);
}

TEST(DebugDraw, TextsNameForceAndDepthAndDeepContactIsRed)
{
	Scene scene;
	Recorder drawn;
	scene.world.debugDraw(drawn);
	EXPECT_EQ(drawn.texts, 1);
	EXPECT_NEAR(drawn.newton, kMass * kGravity, 0.02 * kMass * kGravity);
	EXPECT_GT(drawn.millimetres, 0);
	scene.body.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(kHalf - 0.02), 0)));
	scene.world.bullet().performDiscreteCollisionDetection();
	Recorder deep;
	scene.world.debugDraw(deep);
	EXPECT_NEAR(deep.reddest, 1, 1e-6);
	EXPECT_NEAR(deep.millimetres, 20, 0.5);
}

TEST(DebugDraw, BallsAreThoseOfTheChosenTreeAndLieInTheBody)
{
	Scene scene;
	btISTDebugDraw what;
	what.mostBalls = 1 << 20;
	for (const int balls : {-1, 0, 1})
	{
		const std::size_t expected = balls < 0 ? scene.tree->spheres.size()
			: balls == 0                       ? scene.tree->law.ballCount()
			: scene.tree->levels.empty()       ? 0
											   : scene.tree->levels[0].ballCount();
		what.balls = balls;
		Recorder drawn;
		scene.world.debugDraw(drawn, what);
		EXPECT_EQ(static_cast<std::size_t>(drawn.spheres), expected) << balls;
		EXPECT_LT(drawn.outside, 1.05 * kHalf) << balls;
	}
	what.balls = 0;
	what.mostBalls = 10;
	Recorder few;
	scene.world.debugDraw(few, what);
	EXPECT_GT(few.spheres, 0);
	EXPECT_LE(few.spheres, 10);
}

TEST(DebugDraw, NothingIsAllocatedAndNoDebugModeDrawsNothing)
{
	Scene scene;
	btISTDebugDraw what;
	what.balls = 0;
	Recorder drawn;
	const long before = allocationCount();
	scene.world.debugDraw(drawn, what);
	EXPECT_EQ(allocationCount(), before);
	EXPECT_GT(drawn.lines, 0);
	Recorder off;
	off.mode = btIDebugDraw::DBG_NoDebug;
	scene.world.debugDraw(off, what);
	EXPECT_EQ(off.lines + off.spheres, 0);
}
