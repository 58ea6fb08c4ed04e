// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/PlanarBody.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using namespace ist;

namespace
{
/// Compares the depth of the laid out field with the closed form, at points of the ball.
void expectDepthOf(const AnalyticField& field, const BodyBall& ball, std::mt19937& random)
{
	PlanarBody planar;
	ASSERT_TRUE(PlanarBody::canLayOut(field, ball));
	if (!planar.place(field, ball)) return;
	const BodySurface& body = planar.body();
	ASSERT_EQ(body.field.validate(), "");
	std::uniform_real_distribution<double> u(-1, 1);
	const Pose X_BF = inverse(planar.X_FB());
	for (int i = 0; i < 300; ++i)
	{
		const Vec3 way = normalized({u(random), u(random), u(random)}), p = ball.center + ball.radius * u(random) * way;
		const Vec3 x = X_BF * p;
		const Box& domain = body.field.domain;
		bool isInside = true;
		for (int axis = 0; axis < 3; ++axis) isInside &= x[axis] > domain.lower[axis] && x[axis] < domain.upper[axis];
		if (!isInside)
		{
			EXPECT_LT(field.depth(p), 0);
			continue;
		}
		const DepthField::Value found = body.field.at(x);
		EXPECT_NEAR(found.depth, field.depth(p), 1e-6 * (ball.radius + std::fabs(field.depth(p))));
		EXPECT_NEAR(norm(found.gradient), 1, 1e-6);
	}
}
}  // namespace

TEST(PlanarBody, DepthIsThatOfTheClosedForm)
{
	std::mt19937 random(1);
	std::uniform_real_distribution<double> u(-1, 1);
	for (int i = 0; i < 300; ++i)
	{
		const Vec3 half{std::exp(2 * u(random)), std::exp(2 * u(random)), std::exp(2 * u(random))};
		const BodyBall ball{{1.2 * half.x * u(random), 1.2 * half.y * u(random), 1.2 * half.z * u(random)}, std::exp(3 * u(random))};
		expectDepthOf(BoxField(half), ball, random);
		const Vec3 n = normalized({u(random), u(random), u(random)});
		expectDepthOf(HalfSpaceField(n, dot(n, ball.center) + 3 * ball.radius * u(random)), ball, random);
	}
}

TEST(PlanarBody, CubeHasAllItsCellsAndFaces)
{
	PlanarBody planar;
	ASSERT_TRUE(planar.place(BoxField({1, 1, 1}), {{0.1, 0.2, 0.3}, 3}));
	EXPECT_EQ(planar.body().surface.elements.size(), 6U);
	EXPECT_EQ(planar.body().field.cells.size(), 32U);
	double area = 0;
	for (const SurfaceElement& e : planar.body().surface.elements)
	{
		area += e.area;
		const Vec3 normal = normalized(cross(toVec3(e.e1), toVec3(e.e2)));
		EXPECT_NEAR(norm(normal - toVec3(e.normal)), 0, 1e-6);
		EXPECT_GT(dot(normal, toVec3(e.center) + planar.X_FB().translation), 0.99);
	}
	EXPECT_NEAR(area, 24, 1e-5);
}

TEST(PlanarBody, FloorUnderASmallBodyIsOneCellAndOneFace)
{
	PlanarBody planar;
	ASSERT_TRUE(planar.place(BoxField({25, 0.5, 25}), {{-20, 0.55, 13}, 0.1}));
	EXPECT_EQ(planar.body().surface.elements.size(), 1U);
	EXPECT_EQ(planar.body().field.cells.size(), 1U);
	EXPECT_LT(planar.body().field.domain.longestSide(), 0.31);
	EXPECT_FALSE(planar.place(BoxField({25, 0.5, 25}), {{-20, 0.65, 13}, 0.1}));
}

TEST(PlanarBody, CurvedFormsAndSizesBeyondFloatsAreNotLaidOut)
{
	const BodyBall ball{{}, 1};
	EXPECT_FALSE(PlanarBody::canLayOut(SphereField(1), ball));
	EXPECT_FALSE(PlanarBody::canLayOut(CylinderField(1, 1), ball));
	EXPECT_FALSE(PlanarBody::canLayOut(BoxField({1, 1, 1e-6}), ball));
	EXPECT_FALSE(PlanarBody::canLayOut(HalfSpaceField({0, 0, 1}, 1e12), ball));
	EXPECT_FALSE(PlanarBody::canLayOut(BoxField({1, 1, -1}), ball));
}
