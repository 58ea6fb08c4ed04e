// SPDX-License-Identifier: Zlib
#include "demos/scenes/HapticBunny/HapticBunny.h"

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "TestSupport/SceneFiles/AssetCache.h"
#include "demos/scenes/Truth/MeshBelowPlane.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

using namespace ist;
using namespace scenes;

namespace
{
/// An ellipsoid that stands stably, with half axes of 0.1, 0.06 and 0.08 m.
Mesh pebble()
{
	Mesh mesh = makeSphereMesh(1, 4);
	for (Vec3& p : mesh.vertices) p = {0.1 * p.x, 0.06 * p.y, 0.08 * p.z};
	return mesh;
}

HapticBunnyOptions pebbleOptions()
{
	HapticBunnyOptions options;
	options.given = pebble();
	options.spheres = 1000;
	options.virtualTime = true;
	options.comparisons = 6;
	return options;
}

/// Compares all members of a sample except wall-clock measurements.
void expectSameBytes(const TraceSample& a, const TraceSample& b, size_t at)
{
	TraceSample x = a, y = b;
	x.queryMicroseconds = y.queryMicroseconds = 0;
	ASSERT_EQ(std::memcmp(&x, &y, sizeof x), 0) << "tick " << at;
}
static_assert(sizeof(TraceSample) % sizeof(double) == 0 && std::is_trivially_copyable_v<TraceSample>, "compared as bytes");
}  // namespace

TEST(HapticBunny, HandPressesSlidesTurnsAndComesFree)
{
	const Result<HapticBunnyOutcome> run = runHapticBunny(pebbleOptions());
	ASSERT_TRUE(run) << run.error().message;
	const HapticBunnyOutcome& o = run.value();
	EXPECT_TRUE(o.ok());
	for (const std::string& phase : o.phasesWithoutContact) ADD_FAILURE() << "no contact: " << phase;
	// Only the ramp of the first half second acts, while the hand drags the free tool.
	EXPECT_LE(o.safety.ramped, 500u);
	EXPECT_EQ(o.overruns + o.deviceErrors + (o.safety.total() - o.safety.ramped) + o.droppedContacts, 0u);
	// The hand's spring aims at 4 N, less what coupling and contact yield.
	EXPECT_GT(o.maxForce, 2);
	EXPECT_LT(o.maxForce, 4.5);
	EXPECT_GT(o.maxTorque, 1e-3);
	EXPECT_LT(o.work, 0);  // friction and damping take energy from the hand
	EXPECT_GE(o.comparisons.size(), 6u);
	for (const TraceComparison& c : o.comparisons)
		std::printf("  volume %.1f mm3, error %+.1f (sigma %.1f); force %.2f N, error %.2f (sigma %.2f)\n", 1e9 * c.volumeTruth,
			1e9 * c.volumeError, 1e9 * o.trace[c.sample].volumeSigma, norm(c.forceTruth), c.forceError, o.trace[c.sample].forceSigma);
	std::printf("  volume rms %.2f %%, force rms %.2f %%, direction %.2f deg, sinkage %.3f mm (tree %.3f, mesh %.3f)\n", 100 * o.volumeRms,
		100 * o.forceRms, 57.2958 * o.forceDirection, 1e3 * o.sinkage.measured, 1e3 * o.sinkage.byTree, 1e3 * o.sinkage.byMesh);
}

// The body must rest at the depth that follows from the tree's own force curve, however accurate that curve is.
TEST(HapticBunny, BodyRestsWhereTheTreeCarriesItsWeight)
{
	HapticBunnyOptions options = pebbleOptions();
	options.comparisons = 0;
	const Result<HapticBunnyOutcome> run = runHapticBunny(options);
	ASSERT_TRUE(run) << run.error().message;
	const Sinkage& s = run.value().sinkage;
	EXPECT_NEAR(s.measured, s.byTree, 0.01 * s.byTree);
	EXPECT_GT(s.byMesh, 0);
}

TEST(HapticBunny, RunInVirtualTimeIsBitIdenticalTwice)
{
	HapticBunnyOptions options = pebbleOptions();
	options.comparisons = 0;
	const Result<HapticBunnyOutcome> one = runHapticBunny(options), two = runHapticBunny(options);
	ASSERT_TRUE(one && two);
	ASSERT_GT(one.value().trace.size(), 10000u);
	ASSERT_EQ(one.value().trace.size(), two.value().trace.size());
	for (size_t i = 0; i < one.value().trace.size(); ++i) expectSameBytes(one.value().trace[i], two.value().trace[i], i);
	EXPECT_EQ(one.value().work, two.value().work);
}

// The hand must not notice which thread steps the world, and how often, while the body stands firmly.
TEST(HapticBunny, DecoupledModeFeelsLikeSimpleMode)
{
	HapticBunnyOptions options = pebbleOptions();
	options.comparisons = 0;
	const Result<HapticBunnyOutcome> simple = runHapticBunny(options);
	ASSERT_TRUE(simple) << simple.error().message;
	const HapticBunnyOutcome& s = simple.value();
	options.decoupled = true;
	const Result<HapticBunnyOutcome> decoupled = runHapticBunny(options);
	ASSERT_TRUE(decoupled) << decoupled.error().message;
	const HapticBunnyOutcome& d = decoupled.value();
	EXPECT_TRUE(d.ok());
	EXPECT_EQ(d.worldRate, 60);
	EXPECT_EQ(d.overruns + d.deviceErrors + d.decoupled.fadedTicks, 0u);
	EXPECT_NEAR(d.maxForce, s.maxForce, 0.05 * s.maxForce);
	EXPECT_NEAR(d.maxTorque, s.maxTorque, 0.1 * s.maxTorque);
	EXPECT_NEAR(d.work, s.work, 0.05 * std::fabs(s.work));
	EXPECT_GT(norm(d.decoupled.toTool), 1);
	EXPECT_LT(norm(d.decoupled.underWay), 1e-9 * norm(d.decoupled.toTool));
	std::printf("  world at 60 Hz: %.3f N, %.2f N mm, %.2f mJ; simple mode %.3f N, %.2f N mm, %.2f mJ\n", d.maxForce, 1e3 * d.maxTorque,
		1e3 * d.work, s.maxForce, 1e3 * s.maxTorque, 1e3 * s.work);
}

TEST(AssetCache, IsReadTheSecondTimeAndBuiltAnewWhenItDoesNotFit)
{
	const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) /
		("asset_cache_" + std::to_string(std::random_device()()));
	BuildOptions options;
	options.maxSpheres = 100;
	std::vector<std::string> said;
	const auto ask = [&](const Mesh& mesh) {
		return treeFromCache(mesh, options, folder.string(), "part", [&](const std::string& text) { said.push_back(text); }).value();
	};
	const Mesh box = makeBoxMesh({0.1, 0.2, 0.3}), other = makeBoxMesh({0.1, 0.2, 0.4});

	const CachedTree first = ask(box), second = ask(box);
	EXPECT_FALSE(first.loaded);
	EXPECT_TRUE(second.loaded);
	EXPECT_EQ(encodeAsset(*first.tree), encodeAsset(*second.tree));
	EXPECT_TRUE(said.empty());
	const std::filesystem::path file = std::filesystem::directory_iterator(folder)->path();

	EXPECT_FALSE(ask(other).loaded);  // another name
	ASSERT_TRUE(saveAsset(*ask(other).tree, file.string()));
	EXPECT_FALSE(ask(box).loaded);  // the right name, the wrong mesh
	EXPECT_EQ(said.size(), 1u);
	EXPECT_TRUE(ask(box).loaded);

	std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(2000).write("damaged!", 8);
	EXPECT_FALSE(ask(box).loaded);
	EXPECT_EQ(said.size(), 2u);
	options.seed = 2;
	EXPECT_FALSE(ask(box).loaded);
	EXPECT_EQ(said.size(), 2u);
	std::filesystem::remove_all(folder);
}

TEST(MeshBelowPlane, IsTheCapOfABallAndTheSlabOfABox)
{
	std::mt19937_64 random(5);
	std::uniform_real_distribution<double> u(-1, 1);
	const Mesh ball = makeSphereMesh(0.1, 6), box = makeBoxMesh({0.3, 0.2, 0.1});
	for (int i = 0; i < 5; ++i)
	{
		Pose X;
		X.rotation = rotationMatrix(quaternionFromRotationVector(Vec3{2 * u(random), 2 * u(random), 2 * u(random)}));
		X.translation = Vec3{u(random), i == 0 ? 1000 : u(random), u(random)};
		const double depth = 0.1 * (1 + 0.8 * u(random)), height = X.translation.y - 0.1 + depth;
		// The mesh is inside the ball by at most 5e-5 of its radius.
		EXPECT_NEAR(volumeBelow(ball, X, height), 3.14159265358979 * depth * depth * (0.1 - depth / 3), 2e-3 * 4.19e-3);
		X.rotation = Mat3();
		EXPECT_NEAR(volumeBelow(box, X, X.translation.y - 0.2 + depth), 0.6 * 0.2 * depth, 1e-12);
		EXPECT_NEAR(lowestPoint(box, X), X.translation.y - 0.2, 1e-12);
	}
}
