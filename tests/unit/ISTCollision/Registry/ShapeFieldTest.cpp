// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "BulletISTCollision/Registry/btISTShapeField.h"

#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

namespace
{
/// Collects the ends of all lines that Bullet draws for a shape.
struct LineEnds : btIDebugDraw
{
	std::vector<ist::Vec3> ends;
	void drawLine(const btVector3& from, const btVector3& to, const btVector3&) override
	{
		ends.push_back(toVec3(from));
		ends.push_back(toVec3(to));
	}
	void drawContactPoint(const btVector3&, const btVector3&, btScalar, int, const btVector3&) override {}
	void reportErrorWarning(const char*) override {}
	void draw3dText(const btVector3&, const char*) override {}
	void setDebugMode(int) override {}
	int getDebugMode() const override { return DBG_DrawWireframe; }
};

std::vector<ist::Vec3> drawn(const btCollisionShape& shape)
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	btDbvtBroadphase broadphase;
	btCollisionWorld world(&dispatcher, &broadphase, &configuration);
	LineEnds lines;
	world.setDebugDrawer(&lines);
	world.debugDrawObject(btTransform::getIdentity(), &shape, btVector3(1, 1, 1));
	return lines.ends;
}

struct NamedShape
{
	const char* name;
	std::unique_ptr<btCollisionShape> shape;
};

std::vector<NamedShape> shapes()
{
	std::vector<NamedShape> all;
	const auto add = [&](const char* name, auto* shape) { all.push_back({name, std::unique_ptr<btCollisionShape>(shape)}); };
	add("box", new btBoxShape(btVector3(btScalar(.5), btScalar(.3), btScalar(.7))));
	add("sphere", new btSphereShape(btScalar(.6)));
	add("capsule", new btCapsuleShape(btScalar(.3), btScalar(.8)));
	add("capsule X", new btCapsuleShapeX(btScalar(.3), btScalar(.8)));
	add("capsule Z", new btCapsuleShapeZ(btScalar(.3), btScalar(.8)));
	add("cylinder", new btCylinderShape(btVector3(btScalar(.4), btScalar(.6), btScalar(.4))));
	add("cylinder X", new btCylinderShapeX(btVector3(btScalar(.6), btScalar(.4), btScalar(.4))));
	add("cylinder Z", new btCylinderShapeZ(btVector3(btScalar(.4), btScalar(.4), btScalar(.6))));
	add("cone", new btConeShape(btScalar(.5), btScalar(1.2)));
	add("cone X", new btConeShapeX(btScalar(.5), btScalar(1.2)));
	add("cone Z", new btConeShapeZ(btScalar(.5), btScalar(1.2)));
	return all;
}

void expectDrawnOnTheSurface(const char* name, const btCollisionShape& shape)
{
	const btISTShapeField closed(&shape);
	ASSERT_TRUE(closed.field()) << name;
	const ist::Pose X_FS = ist::inverse(closed.X_SF());
	const std::vector<ist::Vec3> ends = drawn(shape);
	ASSERT_GT(ends.size(), 20u) << name;
	int outermost = 0;
	for (const ist::Vec3& p : ends)
	{
		const double depth = closed.field()->depth(X_FS * p);
		EXPECT_GT(depth, -1e-5) << name;
		outermost += depth < 1e-5;
	}
	// For a cone Bullet also draws the centre of its base circle.
	EXPECT_GT(outermost, int(ends.size()) / 2) << name;
}
}  // namespace

TEST(btISTShapeField, IsTheSurfaceThatBulletDraws)
{
	for (const NamedShape& s : shapes()) expectDrawnOnTheSurface(s.name, *s.shape);
}

TEST(btISTShapeField, FollowsMarginAndLocalScaling)
{
	for (const NamedShape& s : shapes())
	{
		const double before = btISTShapeField(s.shape.get()).field()->volume();
		s.shape->setLocalScaling(btVector3(2, 2, 2));
		expectDrawnOnTheSurface(s.name, *s.shape);
		EXPECT_NEAR(btISTShapeField(s.shape.get()).field()->volume(), 8 * before, 1e-5 * before) << s.name;
		if (s.shape->getShapeType() == SPHERE_SHAPE_PROXYTYPE || s.shape->getShapeType() == CAPSULE_SHAPE_PROXYTYPE) continue;
		s.shape->setMargin(btScalar(.01));
		expectDrawnOnTheSurface(s.name, *s.shape);
		EXPECT_NEAR(btISTShapeField(s.shape.get()).field()->volume(), 8 * before, 1e-4 * before) << s.name;
	}
	btBoxShape box(btVector3(1, 1, 1));
	box.setLocalScaling(btVector3(3, btScalar(.5), 2));
	expectDrawnOnTheSurface("box", box);
	EXPECT_NEAR(btISTShapeField(&box).field()->volume(), 8 * 3, 1e-4);
}

TEST(btISTShapeField, PlaneIsAHalfSpaceBelowItsNormal)
{
	const btStaticPlaneShape plane(btVector3(0, btScalar(.6), btScalar(.8)), btScalar(.25));
	const btISTShapeField closed(&plane);
	ASSERT_TRUE(closed.field());
	EXPECT_TRUE(closed.isHalfSpace());
	EXPECT_NEAR(closed.field()->depth({5, 0, 0}), .25, 1e-6);
	EXPECT_NEAR(closed.field()->depth({5, .6, .8}), -.75, 1e-6);
}

TEST(btISTShapeField, OtherShapesAndLengthsOfNoneHaveNoField)
{
	const btConvexHullShape hull;
	EXPECT_FALSE(btISTShapeField(&hull).field());
	const btCompoundShape compound;
	EXPECT_FALSE(btISTShapeField(&compound).field());
	const btSphereShape point(0);
	EXPECT_FALSE(btISTShapeField(&point).field());
	const btConeShape flat(1, 0);
	EXPECT_FALSE(btISTShapeField(&flat).field());
	const btCapsuleShape thread(0, 1);
	EXPECT_FALSE(btISTShapeField(&thread).field());
	btBoxShape box(btVector3(1, 1, 1));
	box.setLocalScaling(btVector3(1, 0, 1));
	EXPECT_FALSE(btISTShapeField(&box).field());
	const btSphereShape bad(btScalar(std::nan("")));
	EXPECT_FALSE(btISTShapeField(&bad).field());
}
