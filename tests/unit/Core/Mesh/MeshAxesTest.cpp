// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/MeshAxes.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace ist;

namespace
{
Vec3 direction(SignedAxis a)
{
	const double s = a.sign;
	return a.axis == 0 ? Vec3{s, 0, 0} : a.axis == 1 ? Vec3{0, s, 0} : Vec3{0, 0, s};
}
}  // namespace

TEST(MeshAxes, EveryTurnBringsOneAxisToTheOtherAndIsARotation)
{
	for (int i = 0; i < 6; ++i)
		for (int j = 0; j < 6; ++j)
		{
			const SignedAxis from{i / 2, i % 2 ? -1 : 1}, to{j / 2, j % 2 ? -1 : 1};
			Mesh points;
			points.vertices = {direction(from), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
			const Mesh turned = turnedUp(points, from, to);
			EXPECT_EQ(turned.vertices[0], direction(to)) << i << " " << j;
			// The images of the axes are right-handed and of unit length.
			EXPECT_EQ(dot(cross(turned.vertices[1], turned.vertices[2]), turned.vertices[3]), 1) << i << " " << j;
		}
}

TEST(MeshAxes, NoTurnMakesANegativeZero)
{
	for (int i = 0; i < 6; ++i)
		for (int j = 0; j < 6; ++j)
		{
			Mesh points;
			points.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
			for (const Vec3& v : turnedUp(points, {i / 2, i % 2 ? -1 : 1}, {j / 2, j % 2 ? -1 : 1}).vertices)
				for (const double x : {v.x, v.y, v.z}) EXPECT_FALSE(x == 0 && std::signbit(x)) << i << " " << j;
		}
}

TEST(MeshAxes, ZBecomesYAsReadersOfColladaTurnIt)
{
	Mesh point;
	point.vertices = {{1, 2, 3}};
	EXPECT_EQ(turnedUp(point, {2, 1}, {1, 1}).vertices[0], (Vec3{1, 3, -2}));
}

TEST(MeshAxes, TextNamesAnAxis)
{
	for (const char* text : {"x", "+x", "X"}) EXPECT_TRUE(signedAxis(text) && signedAxis(text)->axis == 0 && signedAxis(text)->sign == 1);
	const auto axes = upAxes("-x"), both = upAxes("z,-x");
	ASSERT_TRUE(axes && both);
	EXPECT_TRUE(axes->from.axis == 0 && axes->from.sign == -1 && axes->to.axis == 1 && axes->to.sign == 1);
	EXPECT_TRUE(both->from.axis == 2 && both->from.sign == 1 && both->to.axis == 0 && both->to.sign == -1);
	for (const char* text : {"", ",", "z,", ",z", "z,y,x", "w"}) EXPECT_FALSE(upAxes(text)) << text;
	EXPECT_TRUE(signedAxis("-z") && signedAxis("-z")->axis == 2 && signedAxis("-z")->sign == -1);
	for (const char* text : {"", "-", "w", "xy", "--x", "8"}) EXPECT_FALSE(signedAxis(text)) << text;
}
