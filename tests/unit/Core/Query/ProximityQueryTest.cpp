// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/ProximityQuery.h"

#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "tests/unit/CountingAllocator.h"

#include <gtest/gtest.h>

#include <cmath>

#include <limits>
#include <random>

using namespace ist;

namespace
{
InnerSphereTree cloudBody(int count, unsigned seed, const Vec3& origin)
{
	std::mt19937 random(seed);
	std::uniform_real_distribution<float> place(-1, 1), radius(0.005f, 0.05f);
	std::vector<Sphere> spheres(static_cast<size_t>(count));
	for (Sphere& s : spheres)
	{
		s.x = place(random);
		s.y = place(random);
		s.z = place(random);
		s.r = radius(random);
	}
	InnerSphereTree body;
	body.origin = origin;
	body.maxGap = 0.01;
	body.spheres = std::move(spheres);
	body.inner = buildInnerTree(body.spheres);
	return body;
}

double bruteForce(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB)
{
	double best = std::numeric_limits<double>::infinity();
	for (const Sphere& a : A.spheres)
		for (const Sphere& b : B.spheres)
		{
			const Vec3 p = X_AB * (B.origin + b.center());
			best = std::min(best, distance(p, A.origin + a.center()) - a.r - b.r);
		}
	return std::max(0.0, best);
}

/// The nearest point of a triangle: inside it, or on an edge.
Vec3 nearestOfTriangle(const Vec3& p, const Vec3 (&t)[3])
{
	const Vec3 n = cross(t[1] - t[0], t[2] - t[0]);
	const Vec3 foot = p - n * (dot(n, p - t[0]) / squaredNorm(n));
	bool inside = true;
	Vec3 best = t[0];
	for (int k = 0; k < 3; ++k)
	{
		const Vec3 a = t[k], edge = t[(k + 1) % 3] - a;
		inside = inside && dot(cross(edge, foot - a), n) >= 0;
		const Vec3 q = a + edge * std::clamp(dot(p - a, edge) / squaredNorm(edge), 0.0, 1.0);
		if (squaredNorm(p - q) < squaredNorm(p - best)) best = q;
	}
	return inside ? foot : best;
}

double segmentDistance(const Vec3& p, const Vec3& d, const Vec3& q, const Vec3& e)
{
	// The nearest points are the feet of the common normal if both lie within the segments. Otherwise an end of one segment is nearest
	// to the other.
	const double dd = squaredNorm(d), ee = squaredNorm(e), de = dot(d, e), det = dd * ee - de * de;
	const Vec3 r = q - p;
	double best = std::numeric_limits<double>::infinity();
	if (det > 1e-14 * dd * ee)
	{
		const double s = (dot(r, d) * ee - dot(r, e) * de) / det, t = (dot(r, d) * de - dot(r, e) * dd) / det;
		if (s >= 0 && s <= 1 && t >= 0 && t <= 1) best = distance(p + d * s, q + e * t);
	}
	for (const double s : {0.0, 1.0})
	{
		const Vec3 a = p + d * s, b = q + e * s;
		best = std::min(best, distance(a, q + e * std::clamp(dot(a - q, e) / ee, 0.0, 1.0)));
		best = std::min(best, distance(b, p + d * std::clamp(dot(b - p, d) / dd, 0.0, 1.0)));
	}
	return best;
}

/// Distance of meshes that are apart: it is between a vertex and a triangle, or between two edges.
double meshDistance(const Mesh& A, const Mesh& B, const Pose& X_AB)
{
	double best = std::numeric_limits<double>::infinity();
	const Mesh moved = transformed(B, X_AB);
	const auto corners = [](const Mesh& mesh, size_t i, Vec3(&t)[3]) {
		for (int k = 0; k < 3; ++k) t[k] = mesh.vertices[size_t(mesh.triangles[i][size_t(k)])];
	};
	Vec3 a[3], b[3];
	for (size_t i = 0; i < A.triangles.size(); ++i)
	{
		corners(A, i, a);
		for (size_t j = 0; j < moved.triangles.size(); ++j)
		{
			corners(moved, j, b);
			for (int k = 0; k < 3; ++k)
			{
				best = std::min(best, distance(a[k], nearestOfTriangle(a[k], b)));
				best = std::min(best, distance(b[k], nearestOfTriangle(b[k], a)));
				for (int l = 0; l < 3; ++l)
					best = std::min(best, segmentDistance(a[k], a[(k + 1) % 3] - a[k], b[l], b[(l + 1) % 3] - b[l]));
			}
		}
	}
	return best;
}

struct MeshBody
{
	Mesh mesh;
	InnerSphereTree tree;
};
MeshBody packed(const Mesh& mesh)
{
	BuildOptions options;
	options.maxSpheres = 100;
	return {mesh, buildTree(mesh, options).value()};
}
}  // namespace

TEST(ProximityQuery, BoundsTheExactDistanceOfMeshes)
{
	const MeshBody bodies[] = {packed(translated(makeTorusMesh(0.5, 0.2, 12, 6), {100, -40, 7})), packed(makeBoxMesh({0.5, 0.2, 0.1}))};
	std::mt19937 random(8);
	std::uniform_real_distribution<double> u(-1, 1);
	QueryWorkspace workspace;
	int apart = 0;
	for (const MeshBody& A : bodies)
		for (const MeshBody& B : bodies)
			for (int trial = 0; trial < 25; ++trial)
			{
				Pose X;
				X.rotation = rotationMatrix(quaternionFromRotationVector({3 * u(random), 3 * u(random), 3 * u(random)}));
				const double reach = trial % 3 == 0 ? 3 : 1.1;
				X.translation = A.tree.origin + Vec3{reach * u(random), reach * u(random), reach * u(random)} - X.rotation * B.tree.origin;
				const Distance d = queryDistance(A.tree, B.tree, X);
				EXPECT_LE(d.lower, d.upper);
				EXPECT_NEAR(distance(d.pointA, d.pointB), d.upper, 1e-6);
				const double exact = meshDistance(A.mesh, B.mesh, X);
				if (d.upper == 0 || queryOverlap(A.tree, B.tree, X, workspace).total.volume > 0) continue;
				++apart;
				EXPECT_GE(d.upper, exact - 1e-6);
				EXPECT_LE(d.lower, exact + 1e-6);
			}
	EXPECT_GT(apart, 30);
}

TEST(ProximityQuery, PointsOfTwoSpheresHaveAClosedForm)
{
	const auto ball = [](double r) {
		InnerSphereTree body;
		body.origin = {1, 2, 3};
		body.inner = buildInnerTree(std::vector<Sphere>{{0, 0, 0, float(r)}});
		return body;
	};
	const InnerSphereTree A = ball(0.5), B = ball(0.25);
	Pose X;
	X.rotation = rotationMatrix(quaternionFromRotationVector({0, 0, 1}));
	const auto at = [&](const Vec3& c) {
		X.translation = A.origin + c - X.rotation * B.origin;
		return queryDistance(A, B, X);
	};
	const Distance far = at({0, 2, 0});
	EXPECT_NEAR(far.upper, 1.25, 1e-6);
	EXPECT_NEAR(distance(far.pointA, A.origin + Vec3{0, 0.5, 0}), 0, 1e-6);
	EXPECT_NEAR(distance(far.pointB, A.origin + Vec3{0, 1.75, 0}), 0, 1e-6);
	const Distance met = at({0.6, 0, 0}), inside = at({0.1, 0, 0}), same = at({});
	EXPECT_EQ(met.upper, 0);
	EXPECT_NEAR(distance(met.pointA, A.origin + Vec3{0.425, 0, 0}), 0, 1e-6);
	EXPECT_NEAR(distance(inside.pointB, A.origin + Vec3{0.1, 0, 0}), 0, 1e-6);
	EXPECT_NEAR(distance(same.pointB, A.origin), 0, 1e-6);
}

TEST(ProximityQuery, AllocatesNothing)
{
	const InnerSphereTree A = cloudBody(500, 1, {});
	Pose X;
	X.translation = {3, 0, 0};
	const long before = allocationCount();
	queryDistance(A, A, X);
	EXPECT_EQ(allocationCount(), before);
}

TEST(ProximityQuery, AgreesWithBruteForce)
{
	std::mt19937 random(3);
	std::uniform_real_distribution<double> uniform(-1, 1);
	for (const int count : {1, 5, 100, 1000})
		for (int trial = 0; trial < 10; ++trial)
		{
			const InnerSphereTree A = cloudBody(count, 1 + trial, {1, 2, 3}), B = cloudBody(count, 100 + trial, {-5, 0, 1});
			Pose X;
			X.rotation = rotationMatrix(quaternionFromRotationVector({3 * uniform(random), uniform(random), uniform(random)}));
			const double reach = trial % 3 == 0 ? 0.5 : trial % 3 == 1 ? 3 : 50;
			const Vec3 shift{reach * uniform(random), reach * uniform(random), reach * uniform(random)};
			X.translation = A.origin + shift - X.rotation * B.origin;
			const double expected = bruteForce(A, B, X);
			const Distance d = queryDistance(A, B, X);
			EXPECT_NEAR(d.upper, expected, 1e-9 * (1 + expected));
			EXPECT_NEAR(d.lower, std::max(0.0, expected - 0.02), 1e-9 * (1 + expected));
		}
}

TEST(ProximityQuery, ZeroWhenSpheresIntersectAndWidestWithoutInformation)
{
	const InnerSphereTree A = cloudBody(50, 1, {});
	EXPECT_EQ(queryDistance(A, A, Pose{}).upper, 0);
	EXPECT_EQ(queryDistance(A, A, Pose{}).lower, 0);
	Pose bad;
	bad.translation.x = NAN;
	EXPECT_EQ(queryDistance(A, A, bad).upper, std::numeric_limits<double>::infinity());
	EXPECT_EQ(queryDistance(A, A, bad).lower, 0);
	EXPECT_EQ(queryDistance(A, InnerSphereTree{}, Pose{}).upper, std::numeric_limits<double>::infinity());
}
