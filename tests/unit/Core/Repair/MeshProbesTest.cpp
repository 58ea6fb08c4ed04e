// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshProbes.h"
#include "tests/unit/Core/Repair/RepairChecks.h"
#include "tests/unit/ResidentMemory.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <random>
#include <thread>

using namespace ist;

namespace
{
/// Two boxes of these half extents, one moved along x. What lies in both is counted twice: a closed form.
Mesh overlapping(const Vec3& half, double move) { return joined(makeBoxMesh(half), translated(makeBoxMesh(half), {move, 0, 0})); }

double shareOfOverlap(const Vec3& half, double move)
{
	const double both = 2 * half.x - move;
	return both / (2 * half.x + move);
}
}  // namespace

TEST(MeshProbes, WhatIsCountedTwiceIsMeasuredByVolume)
{
	std::mt19937 random(3);
	std::uniform_real_distribution<double> turn(-3, 3);
	for (const Vec3& half : {Vec3{1, 1, 1}, Vec3{1, 0.7, 0.01}, Vec3{1, 1, 1e-4}, Vec3{0.02, 1, 0.03}})
		for (const double share : {0.01, 0.1, 0.5, 1.0, 1.9})
		{
			const double move = share * half.x, wanted = shareOfOverlap(half, move);
			const Mesh mesh = overlapping(half, move);
			EXPECT_NEAR(miscountedShare(mesh, 256), wanted, 0.02 * wanted + 0.005) << half.z << " " << share;
			const Pose X{rotationMatrix(quaternionFromRotationVector({turn(random), turn(random), turn(random)})), {1000, -20, 3}};
			EXPECT_NEAR(miscountedShare(transformed(mesh, X), 256), wanted, 0.04 * wanted + 0.01) << half.z << " " << share << " turned";
		}
}

// A cube without a face. A face is seen from the points of a cube under a sixth of all directions on average, and from each of them under
// less than half.
TEST(MeshProbes, AMissingFaceLeavesASixthOpen)
{
	Mesh cube = makeBoxMesh({1, 1, 1});
	std::erase_if(cube.triangles,
		[&](const auto& t) { return std::all_of(t.begin(), t.end(), [&](uint32_t v) { return cube.vertices[v].y == 1; }); });
	ASSERT_EQ(cube.triangles.size(), 10u);
	const OpenVolume open = openVolume(cube, 32), closed = openVolume(makeBoxMesh({1, 1, 1}), 32);
	EXPECT_NEAR(open.inside, 8, 1e-9);
	EXPECT_NEAR(open.ambiguous, 8.0 / 6, 0.02 * 8 / 6);
	EXPECT_NEAR(closed.inside, 8, 1e-9);
	EXPECT_NEAR(closed.ambiguous, 0, 1e-9);
}

// The crossings of all lines with these layers took 80 MB or more.
TEST(MeshProbes, ManyLayersNeedLittleMemory)
{
	if (!residentBytes()) GTEST_SKIP() << "the system does not say what is resident";
	constexpr int kBodies = 40;
	Mesh layers;
	for (int i = 0; i < kBodies; ++i) layers = joined(layers, makeBoxMesh({1, 1, 1 - 0.01 * i}));
	std::atomic<bool> ends = false;
	std::atomic<long> most = 0;
	const long before = *residentBytes();
	std::thread watch([&] {
		while (!ends) most = std::max(most.load(), *residentBytes());
	});
	// All bodies lie in the first one, and body i has 1 - 0.01 i of its volume. The grid may miss a row of each.
	EXPECT_NEAR(miscountedShare(layers, 256), 39 - 0.01 * 39 * 40 / 2, 39.0 / 256);
	ends = true;
	watch.join();
	EXPECT_LT(most - before, 20 << 20);
}

TEST(MeshProbes, BodiesApartNestedAndEmptyAreCountedRight)
{
	const Mesh box = makeBoxMesh({1, 1, 1});
	EXPECT_EQ(miscountedShare(box, 64), 0);
	EXPECT_EQ(miscountedShare(joined(box, translated(box, {3, 0, 0})), 64), 0);
	EXPECT_EQ(miscountedShare(joined(box, insideOut(makeBoxMesh({0.5, 0.5, 0.5}))), 64), 0) << "a cavity";
	EXPECT_NEAR(miscountedShare(joined(box, makeBoxMesh({0.5, 0.5, 0.5})), 256), 0.125, 0.002) << "a body in solid material";
	EXPECT_TRUE(std::isinf(miscountedShare(insideOut(box), 64)));
	EXPECT_NEAR(miscountedShare(makeSphereMesh(1, 5), 128), 0, 1e-12);
	// Lines that meet edges and corners.
	EXPECT_NEAR(miscountedShare(translated(box, {-0.3819660112501051 * 2 / 64, 0, 0}), 64), 0, 1e-12);
}
