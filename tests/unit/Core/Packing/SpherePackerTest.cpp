// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Packing/SpherePacker.h"

#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

namespace
{
using namespace ist;

// Distance to a triangle by an independent method: to the plane if the foot point lies inside, else to the nearest of three edges.
double distanceToSegment(const Vec3& p, const Vec3& a, const Vec3& b)
{
	const Vec3 d = b - a;
	const double t = std::clamp(dot(p - a, d) / squaredNorm(d), 0.0, 1.0);
	return distance(p, a + d * t);
}

double distanceToTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c)
{
	const Vec3 n = normalized(cross(b - a, c - a));
	const double height = dot(p - a, n);
	const Vec3 foot = p - n * height;
	const bool inside = dot(cross(b - a, foot - a), n) >= 0 && dot(cross(c - b, foot - b), n) >= 0 && dot(cross(a - c, foot - c), n) >= 0;
	if (inside) return std::fabs(height);
	return std::min({distanceToSegment(p, a, b), distanceToSegment(p, b, c), distanceToSegment(p, c, a)});
}

SpherePacking pack(const Mesh& mesh, int64_t count, uint64_t seed = 1, int threads = 0)
{
	PackingOptions options;
	options.threads = threads;
	options.maxSpheres = count;
	options.seed = seed;
	Result<SpherePacking> result = packSpheres(MeshDistance(mesh), options);
	EXPECT_TRUE(result) << result.error().message;
	return result ? std::move(result).value() : SpherePacking{};
}

void expectValid(const Mesh& mesh, const SpherePacking& packing)
{
	int overlaps = 0, protruding = 0;
	for (size_t i = 0; i < packing.spheres.size(); ++i)
	{
		const Sphere& s = packing.spheres[i];
		for (size_t j = 0; j < i; ++j)
			overlaps += distance(s.center(), packing.spheres[j].center()) < double(s.r) + double(packing.spheres[j].r);
		double d = 1e300;
		for (const auto& t : mesh.triangles)
			d = std::min(d, distanceToTriangle(s.center(), mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]));
		protruding += d < double(s.r);
	}
	EXPECT_EQ(overlaps, 0);
	EXPECT_EQ(protruding, 0);
}

TEST(SpherePacker, StoredSpheresNeitherOverlapNorProtrude)
{
	const Mesh meshes[] = {makeBoxMesh({0.1, 0.07, 0.05}), makeTetrahedronMesh(2), makeTorusMesh(1, 0.3, 32, 16),
		makeTorusKnotMesh(1, 0.45, 0.2, 2, 3, 80, 10)};
	for (const Mesh& mesh : meshes)
	{
		const Pose X{rotationMatrix(quaternionFromRotationVector({0.3, -1.1, 0.7})), {0.013, -0.021, 0.017}};
		const Mesh turned = transformed(mesh, X);
		const SpherePacking packing = pack(turned, 400);
		EXPECT_GT(packing.spheres.size(), 100u);
		expectValid(turned, packing);
	}
}

TEST(SpherePacker, FirstSphereOfACubeIsTheInscribedOne)
{
	const SpherePacking packing = pack(makeBoxMesh({1, 1, 1}), 1);
	ASSERT_EQ(packing.spheres.size(), 1u);
	EXPECT_NEAR(packing.spheres[0].r, 1, 1e-6);
	EXPECT_LT(norm(packing.spheres[0].center()), 1e-6);
	EXPECT_NEAR(packing.fill, 4.0 / 3 * 3.14159265358979 / 8, 1e-6);
}

TEST(SpherePacker, RadiiDecreaseButForHolesFoundLateAndAnyPrefixIsThePackingForThatCount)
{
	const Mesh mesh = makeBoxMesh({0.5, 0.4, 0.3});
	const SpherePacking all = pack(mesh, 300), some = pack(mesh, 100);
	ASSERT_EQ(all.spheres.size(), 300u);
	for (size_t i = 0; i < some.spheres.size(); ++i)
	{
		EXPECT_EQ(all.spheres[i].center(), some.spheres[i].center());
		EXPECT_EQ(all.spheres[i].r, some.spheres[i].r);
	}
	// The greedy search places the largest hole that it knows. A hole that only a later start finds can be larger (11 % seen on boxes).
	for (size_t i = 1; i < all.spheres.size(); ++i) EXPECT_LE(all.spheres[i].r, 1.25 * all.spheres[i - 1].r);
}

TEST(SpherePacker, FillsACubeAsTheReferenceGreedyDoes)
{
	// Reference measurements of two independent greedy packers gave 0.837.
	EXPECT_GT(pack(makeBoxMesh({0.5, 0.5, 0.5}), 1000).fill, 0.835);
}

TEST(SpherePacker, LeavesNoRegionWithoutSpheresThatIsThickerThanFourOfItsSmallestRadii)
{
	// The body has thick and thin parts; one of them is separate and smaller than the cells of the first search grid.
	Mesh mesh = makeBoxMesh({0.5, 0.4, 0.02});
	const auto add = [&](const Mesh& part, const Vec3& at) {
		const uint32_t first = uint32_t(mesh.vertices.size());
		for (const Vec3& p : part.vertices) mesh.vertices.push_back(p + at);
		for (const auto& t : part.triangles) mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
	};
	add(makeBoxMesh({0.15, 0.15, 0.15}), {0, 0, 0.3});
	add(makeBoxMesh({0.012, 0.012, 0.012}), {0.7, 0, 0});
	add(makeTorusMesh(0.3, 0.03, 64, 24), {0, 0, -0.5});
	const MeshDistance surface(mesh);
	for (const int64_t count : {300, 3000})
	{
		const SpherePacking packing = pack(mesh, count);
		ASSERT_EQ(int64_t(packing.spheres.size()), count);
		const double smallest =
			std::min_element(packing.spheres.begin(), packing.spheres.end(), [](const Sphere& a, const Sphere& b) { return a.r < b.r; })->r;
		std::mt19937_64 random(9);
		std::uniform_real_distribution<double> u(0, 1);
		const Box box = bounds(mesh);
		double widest = 0;
		for (int inside = 0; inside < 6000;)
		{
			const Vec3 p = box.lower + Vec3{u(random) * box.size().x, u(random) * box.size().y, u(random) * box.size().z};
			if (!surface.contains(p)) continue;
			++inside;
			double clear = surface.closest(p).distance;
			for (const Sphere& s : packing.spheres) clear = std::min(clear, distance(p, s.center()) - s.r);
			widest = std::max(widest, clear);
		}
		EXPECT_LT(widest, 2 * smallest);
		EXPECT_GT(widest, 0.2 * smallest) << "the points see no hole at all";
	}
}

TEST(SpherePacker, SameSeedGivesTheSameSpheres)
{
	const Mesh mesh = makeTorusMesh(1, 0.3, 32, 16);
	const SpherePacking a = pack(mesh, 200, 7), b = pack(mesh, 200, 7);
	ASSERT_EQ(a.spheres.size(), b.spheres.size());
	for (size_t i = 0; i < a.spheres.size(); ++i)
	{
		EXPECT_EQ(a.spheres[i].center(), b.spheres[i].center());
		EXPECT_EQ(a.spheres[i].r, b.spheres[i].r);
	}
}

TEST(SpherePacker, TheThreadCountChangesNoSphere)
{
	const Pose X{rotationMatrix(quaternionFromRotationVector({-0.7, 0.4, 1.3})), {0.02, 0.01, -0.03}};
	const Mesh meshes[] = {transformed(makeTorusKnotMesh(1, 0.45, 0.2, 2, 3, 200, 20), X), makeBoxMesh({0.5, 0.4, 0.3})};
	for (const Mesh& mesh : meshes)
	{
		const SpherePacking one = pack(mesh, 1500, 3, 1), three = pack(mesh, 1500, 3, 3);
		ASSERT_EQ(one.spheres.size(), three.spheres.size());
		for (size_t i = 0; i < one.spheres.size(); ++i)
		{
			EXPECT_EQ(one.spheres[i].center(), three.spheres[i].center());
			EXPECT_EQ(one.spheres[i].r, three.spheres[i].r);
		}
	}
}

TEST(SpherePacker, CanBeCancelled)
{
	PackingOptions options;
	options.maxSpheres = 100000;
	options.progress = [](const char*, double) { return false; };
	const Result<SpherePacking> result = packSpheres(MeshDistance(makeBoxMesh({1, 1, 1})), options);
	ASSERT_FALSE(result);
	EXPECT_TRUE(result.error().cancelled);
}

TEST(SpherePacker, RefusesBadOptionsInWords)
{
	const MeshDistance box(makeBoxMesh({1, 1, 1}));
	PackingOptions none, overfull, negative, notANumber;
	none.maxSpheres = 0;
	overfull.targetFill = 1.5;
	negative.minRadius = -1;
	notANumber.minRadius = std::numeric_limits<double>::quiet_NaN();
	for (const PackingOptions& options : {none, overfull, negative, notANumber})
	{
		const Result<SpherePacking> result = packSpheres(box, options);
		ASSERT_FALSE(result);
		EXPECT_FALSE(result.error().message.empty());
	}
	EXPECT_FALSE(packSpheres(MeshDistance(Mesh{}), {}));
}

/// The number after `text` in a sentence.
double numberAfter(const std::string& sentence, const std::string& text)
{
	const size_t at = sentence.find(text);
	return at == sentence.npos ? std::numeric_limits<double>::quiet_NaN() : std::stod(sentence.substr(at + text.size()));
}

TEST(SpherePacker, SaysWhereTheLargestBallLiesAndWhichLeastRadiusWouldDo)
{
	// A slab and a box beside each other: the largest ball is in the box, of half side 0.25, and cannot be moved.
	Mesh mesh = makeBoxMesh({1, 0.7, 0.1});
	const Mesh box = translated(makeBoxMesh({0.25, 0.25, 0.25}), {3, 1, 2});
	for (const auto& [a, b, c] : box.triangles)
	{
		const auto first = uint32_t(mesh.vertices.size());
		mesh.triangles.push_back({first, first + 1, first + 2});
		for (const uint32_t corner : {a, b, c}) mesh.vertices.push_back(box.vertices[corner]);
	}
	PackingOptions options;
	options.minRadius = 0.3;
	options.origin = {10, 20, 30};
	const Result<SpherePacking> result = packSpheres(MeshDistance(mesh), options);
	ASSERT_FALSE(result);
	const std::string& told = result.error().message;
	EXPECT_NEAR(numberAfter(told, "the largest ball that fits has radius "), 0.25, 1e-3) << told;
	const size_t place = told.find(" m at (");
	ASSERT_NE(place, std::string::npos) << told;
	double x = 0, y = 0, z = 0;
	ASSERT_EQ(std::sscanf(told.c_str() + place, " m at (%lf, %lf, %lf) m", &x, &y, &z), 3) << told;
	EXPECT_NEAR(distance(Vec3{x, y, z}, Vec3{13, 21, 32}), 0, 2e-3) << told;
	options.minRadius = numberAfter(told, "lower the minimum radius (BuildOptions::minRadius) to ");
	EXPECT_TRUE(packSpheres(MeshDistance(mesh), options)) << told;
}

TEST(SpherePacker, ABodyThatIsTooThinForAnyRadiusIsToBeThickened)
{
	PackingOptions options;
	for (const double asked : {0.0, 0.1})
	{
		options.minRadius = asked;
		const Result<SpherePacking> result = packSpheres(MeshDistance(makeBoxMesh({1, 1, 5e-5})), options);
		ASSERT_FALSE(result);
		const std::string& told = result.error().message;
		EXPECT_NEAR(numberAfter(told, "the largest ball that fits has radius "), 5e-5, 1e-6) << told;
		EXPECT_NEAR(numberAfter(told, "thicken the mesh to more than "), 4e-4, 1e-9) << told;
		EXPECT_EQ(told.find("lower the minimum radius"), std::string::npos) << told;
	}
	EXPECT_TRUE(packSpheres(MeshDistance(makeBoxMesh({1, 1, 2.1e-4})), {}));
}
}  // namespace
