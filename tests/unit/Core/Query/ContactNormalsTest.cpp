// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Faces/ContactNormals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <utility>
#include <vector>

using namespace ist;

namespace
{
using SignedFace = std::pair<ContactFace, double>;

ContactFace faceOf(const Vec3& normal, const Vec3& gradient, double area = 1e-6, bool isCurved = false)
{
	ContactFace face;
	face.area = area;
	face.areaNormal = area * normalized(normal);
	face.depth = 1e-4 * area;
	face.pressure = 1e-4 * face.areaNormal;
	face.gradient = normalized(gradient);
	if (isCurved) face.spread.m[0][0] = 1e-3 * area;
	return face;
}

ContactNormals normalsOf(const std::vector<SignedFace>& faces, bool hasFacesA = true)
{
	ContactNormals normals;
	for (const auto& [face, sign] : faces) normals.add(face, sign);
	normals.find(hasFacesA, true);
	for (const auto& [face, sign] : faces) normals.measure(face, sign);
	normals.settle();
	return normals;
}

/// Contact of two surfaces that touch at the origin, A above and B below, sampled on a disc. The functions give the upward normals.
std::vector<SignedFace> touching(const std::function<Vec3(double x, double z)>& ofA, const std::function<Vec3(double x, double z)>& ofB)
{
	std::vector<SignedFace> faces;
	std::mt19937_64 random(5);
	std::uniform_real_distribution<double> u(-0.1, 0.1);
	for (int i = 0; i < 200; ++i)
	{
		const double x = u(random), z = u(random);
		// B's outward normal and A's gradient go up, from B to A.
		if (i % 2) faces.push_back({faceOf(ofB(x, z), ofA(x, z), 1e-6, true), 1});
		else faces.push_back({faceOf(-ofA(x, z), -ofB(x, z), 1e-6, true), -1});
	}
	return faces;
}
}  // namespace

TEST(ContactNormals, AreThoseOfThePlaneUnderAnEdge)
{
	const Vec3 up{0, 1, 0};
	// B is the edge of a cube that points up, and A the plane above it.
	const std::vector<SignedFace> faces = {{faceOf({1, 1, 0}, up), 1}, {faceOf({-1, 1, 0}, up), 1}, {faceOf({0, 0, 1}, up), 1},
		{faceOf({0, 0, -1}, up), 1}, {faceOf(-up, {-1, -1, 0}), -1}, {faceOf(-up, {1, -1, 0}), -1}};
	const ContactNormals normals = normalsOf(faces);
	ASSERT_TRUE(normals.exist());
	EXPECT_TRUE(normals.areOfA());
	EXPECT_TRUE(normals.areFlat());
	EXPECT_EQ(normals.share(), 1);
	Vec3 before, after;
	for (const auto& [face, sign] : faces)
	{
		const Vec3 normal = normals.at(face, sign);
		EXPECT_LT(norm(normal - up), 1e-12);
		const Vec3 pressure = normals.pressure(face, sign, normal);
		EXPECT_EQ(cross(pressure, up), Vec3());
		if (sign < 0) continue;
		before += face.pressure;
		after += pressure;
	}
	EXPECT_LT(norm(before - after), 1e-12 * norm(before));
	// Nothing of an upright face.
	EXPECT_EQ(normals.pressure(faces[2].first, 1, up), Vec3());
}

TEST(ContactNormals, OfABallInAPipeTurnWithThePipe)
{
	const double pipe = 2, ball = 0.5;
	const auto ofPipe = [&](double x, double) { return normalized(Vec3{-x / pipe, 1, 0}); };
	const auto ofBall = [&](double x, double z) { return normalized(Vec3{-x / ball, 1, -z / ball}); };
	for (const bool pipeIsA : {true, false})
	{
		const std::vector<SignedFace> faces = pipeIsA ? touching(ofPipe, ofBall) : touching(ofBall, ofPipe);
		const ContactNormals normals = normalsOf(faces);
		ASSERT_TRUE(normals.exist());
		EXPECT_EQ(normals.areOfA(), pipeIsA);
		EXPECT_FALSE(normals.areFlat());
		for (const auto& [face, sign] : faces)
		{
			const Vec3 ofSmoother = normalized(sign * ((sign > 0) == pipeIsA ? face.gradient : face.areaNormal));
			EXPECT_LT(norm(normals.at(face, sign) - ofSmoother), 1e-9);
		}
	}
}

// In each direction the body counts that is smoother there: on two facets of a pipe that meet below a ball, the pipe along it, and the ball
// across.
TEST(ContactNormals, OfABallOnAKinkTurnWithTheBallAcrossIt)
{
	const double ball = 1;
	const auto ofPipe = [](double x, double) { return normalized(Vec3{x > 0 ? -0.15 : 0.15, 1, 0}); };
	const auto ofBall = [&](double x, double z) { return normalized(Vec3{-x / ball, 1, -z / ball}); };
	const std::vector<SignedFace> faces = touching(ofPipe, ofBall);
	const ContactNormals normals = normalsOf(faces);
	ASSERT_TRUE(normals.exist());
	for (const auto& [face, sign] : faces)
	{
		const Vec3 n = normals.at(face, sign), b = sign * (sign > 0 ? normalized(face.areaNormal) : face.gradient);
		EXPECT_NEAR(n.z, 0, 0.01);
		EXPECT_NEAR(n.x / n.y, b.x / b.y, 0.01);
	}
}

TEST(ContactNormals, DoNotExistWhereBothBodiesAreAlikeOrHaveEdges)
{
	const auto cylinder = [](double radius) { return [=](double x, double) { return normalized(Vec3{-x / radius, 1, 0}); }; };
	EXPECT_FALSE(normalsOf(touching(cylinder(0.5), cylinder(0.51))).exist());
	// Crossed edges.
	const auto alongX = [](double, double z) { return normalized(Vec3{0, 1, z > 0 ? 1.0 : -1.0}); };
	const auto alongZ = [](double x, double) { return normalized(Vec3{x > 0 ? 1.0 : -1.0, 1, 0}); };
	EXPECT_FALSE(normalsOf(touching(alongX, alongZ)).exist());
}

// Faces of B in one cell of A's field, whose gradient is not that of any surface there: at the rim of a pin, two of them held it in its
// bore.
TEST(ContactNormals, AreNotThoseOfAGradientWithoutASurface)
{
	std::vector<SignedFace> slivers = {{faceOf({1, 0, 0}, {0.65, -0.75, 0}), 1}, {faceOf({1, 0, 0.02}, {0.65, -0.75, 0}), 1}};
	// The mean of two normals at right angles.
	for (auto& [face, sign] : slivers) face.gradient = std::sqrt(0.5) * face.gradient;
	EXPECT_FALSE(normalsOf(slivers).areOfA());
	// A half-space has no faces, and every gradient is its own.
	EXPECT_TRUE(normalsOf(slivers, false).areOfA());
	// One face of a cube's corner on a surface whose own faces are missing, which happens below its error.
	const ContactNormals corner = normalsOf({{faceOf({1, 1, 0}, {0, 1, 0}), 1}});
	ASSERT_TRUE(corner.areOfA());
	EXPECT_LT(norm(corner.at(faceOf({1, 1, 0}, {0, 1, 0}), 1) - Vec3{0, 1, 0}), 1e-12);
}
