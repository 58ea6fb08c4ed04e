// SPDX-License-Identifier: Zlib
#include "demos/scenes/Bodies/ImplicitMesh.h"
#include "tests/unit/ClosedMesh.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace scenes;
using ist::Mesh;
using ist::Vec3;

namespace
{
constexpr double kPi = 3.14159265358979323846;

double areaOf(const Mesh& mesh)
{
	double area = 0;
	for (const auto& t : mesh.triangles)
		area += 0.5 * norm(cross(mesh.vertices[t[1]] - mesh.vertices[t[0]], mesh.vertices[t[2]] - mesh.vertices[t[0]]));
	return area;
}
/// The field is the distance to the surface.
void expectSurface(const Mesh& mesh, const std::function<double(const Vec3&)>& field, double cell)
{
	ASSERT_FALSE(mesh.vertices.empty());
	EXPECT_TRUE(isClosed(mesh));
	for (const Vec3& p : mesh.vertices) ASSERT_LT(std::fabs(field(p)), 1e-4 * cell);
}
}  // namespace

TEST(ImplicitMesh, BallOffTheOriginHasTheClosedForms)
{
	const double r = 0.03, cell = 0.001;
	const Vec3 centre{0.3, -0.2, 1000.1};
	const auto field = [&](const Vec3& p) { return r - distance(p, centre); };
	const Vec3 reach{r + 3 * cell, r + 4 * cell, r + 5 * cell};
	const Mesh mesh = meshOfField(field, {centre - reach, centre + reach}, cell);
	expectSurface(mesh, field, cell);
	const double volume = 4 * kPi / 3 * r * r * r, area = 4 * kPi * r * r;
	EXPECT_NEAR(massProperties(mesh).volume, volume, 2e-3 * volume);
	EXPECT_NEAR(areaOf(mesh), area, 2e-3 * area);
	EXPECT_LT(distance(massProperties(mesh).centerOfMass, centre), 1e-2 * cell);
}

TEST(ImplicitMesh, TorusOffTheOriginHasTheClosedForms)
{
	const double R = 0.04, r = 0.01, cell = 0.0008;
	const Vec3 centre{-2, 0.7, 0.1};
	const auto field = [&](const Vec3& p) {
		const Vec3 d = p - centre;
		return r - std::hypot(std::hypot(d.x, d.y) - R, d.z);
	};
	const Vec3 reach{R + r + 3 * cell, R + r + 3 * cell, r + 3 * cell};
	const Mesh mesh = meshOfField(field, {centre - reach, centre + reach}, cell);
	expectSurface(mesh, field, cell);
	const double volume = 2 * kPi * kPi * R * r * r, area = 4 * kPi * kPi * R * r;
	EXPECT_NEAR(massProperties(mesh).volume, volume, 5e-3 * volume);
	EXPECT_NEAR(areaOf(mesh), area, 5e-3 * area);
}
