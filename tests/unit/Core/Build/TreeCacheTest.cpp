// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Build/TreeCache.h"

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Build/TreeWorker.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <unistd.h>
#include <vector>

using namespace ist;

namespace
{
/// A folder for one test, which is removed with the object.
struct Folder
{
	std::filesystem::path path = std::filesystem::path(testing::TempDir()) /
		("ist_cache_" + std::to_string(::getpid()) + testing::UnitTest::GetInstance()->current_test_info()->name());
	Folder() { std::filesystem::remove_all(path); }
	~Folder() { std::filesystem::remove_all(path); }
	int files() const
	{
		int count = 0;
		if (std::filesystem::exists(path))
			for (const auto& entry : std::filesystem::directory_iterator(path)) count += entry.path().extension() == ".ist" ? 1 : 0;
		return count;
	}
	std::filesystem::path only() const { return std::filesystem::directory_iterator(path)->path(); }
};

BuildOptions few(int64_t spheres = 10)
{
	BuildOptions options;
	options.maxSpheres = spheres;
	options.threads = 1;
	return options;
}

Mesh withoutTriangles(Mesh mesh, size_t count)
{
	mesh.triangles.resize(mesh.triangles.size() - count);
	return mesh;
}
}  // namespace

TEST(TreeCache, GivesTheSecondTimeFromTheFileWhatItBuiltTheFirstTime)
{
	const Folder folder;
	const Mesh mesh = makeBoxMesh({0.5, 0.3, 0.2});
	const auto first = cachedTree(mesh, few(), folder.path.string());
	ASSERT_TRUE(first) << first.error().message;
	EXPECT_FALSE(first.value().fromCache);
	EXPECT_EQ(first.value().note, "");
	EXPECT_EQ(folder.files(), 1);
	const auto second = cachedTree(mesh, few(), folder.path.string());
	ASSERT_TRUE(second);
	EXPECT_TRUE(second.value().fromCache);
	EXPECT_NEAR(second.value().tree->volume, 8 * 0.5 * 0.3 * 0.2, 1e-12);
	EXPECT_EQ(encodeAsset(*first.value().tree), encodeAsset(*second.value().tree));
}

TEST(TreeCache, KeepsEveryMeshAndEverySettingApart)
{
	const Mesh mesh = makeBoxMesh({0.5, 0.3, 0.2});
	BuildOptions other = few();
	const uint64_t key = treeKey(mesh, other);
	EXPECT_NE(treeKey(translated(mesh, {0, 0, 1e-9}), other), key);
	other.threads = 2;
	EXPECT_EQ(treeKey(mesh, other), key);
	other.seed = 2;
	EXPECT_NE(treeKey(mesh, other), key);
	other = few(11);
	EXPECT_NE(treeKey(mesh, other), key);
	other = few();
	other.minRadius = 1e-3;
	EXPECT_NE(treeKey(mesh, other), key);
	other = few();
	other.targetFill = 0.5;
	EXPECT_NE(treeKey(mesh, other), key);
	other = few();
	other.repair = RepairMode::Off;
	EXPECT_NE(treeKey(mesh, other), key);
}

TEST(TreeCache, ReplacesAFileThatIsDamagedOrOfSomethingElse)
{
	const Folder folder;
	const Mesh mesh = makeBoxMesh({0.5, 0.3, 0.2});
	ASSERT_TRUE(cachedTree(mesh, few(), folder.path.string()));
	std::filesystem::resize_file(folder.only(), 100);
	const auto cut = cachedTree(mesh, few(), folder.path.string());
	ASSERT_TRUE(cut);
	EXPECT_FALSE(cut.value().fromCache);
	EXPECT_NE(cut.value().note, "");
	InnerSphereTree other = *cut.value().tree;
	other.provenance.meshHash ^= 1;
	ASSERT_TRUE(saveAsset(other, folder.only().string()));
	const auto foreign = cachedTree(mesh, few(), folder.path.string());
	ASSERT_TRUE(foreign);
	EXPECT_FALSE(foreign.value().fromCache);
	EXPECT_EQ(foreign.value().tree->provenance.meshHash, meshHash(mesh));
	EXPECT_TRUE(cachedTree(mesh, few(), folder.path.string()).value().fromCache);
}

// The key contains the version, so such a file lies there only if somebody renamed it.
TEST(TreeCache, RebuildsAFileOfAnOlderFormat)
{
	const Folder folder;
	const Mesh mesh = makeBoxMesh({0.5, 0.3, 0.2});
	const auto first = cachedTree(mesh, few(), folder.path.string());
	ASSERT_TRUE(first);
	{
		std::fstream file(folder.only(), std::ios::in | std::ios::out | std::ios::binary);
		file.seekp(8);
		file.put(char(kAssetVersion - 1));
	}
	const auto rebuilt = cachedTree(mesh, few(), folder.path.string());
	ASSERT_TRUE(rebuilt) << rebuilt.error().message;
	EXPECT_FALSE(rebuilt.value().fromCache);
	EXPECT_NE(rebuilt.value().note.find("format version 6"), std::string::npos) << rebuilt.value().note;
	EXPECT_EQ(encodeAsset(*rebuilt.value().tree), encodeAsset(*first.value().tree));
	EXPECT_TRUE(cachedTree(mesh, few(), folder.path.string()).value().fromCache);
}

TEST(TreeCache, BuildsAllTheSameWhereItCannotWrite)
{
	const Folder folder;
	std::ofstream(folder.path) << "a file where the folder should be";
	const auto made = cachedTree(makeBoxMesh({0.5, 0.3, 0.2}), few(), folder.path.string());
	ASSERT_TRUE(made);
	EXPECT_NE(made.value().note.find(folder.path.string()), std::string::npos) << made.value().note;
}

// A sphere lacks its cap. If 1 triangle of 1280 is missing, the hole can have changed the volume only a little; if half of them are
// missing, by all of it.
TEST(TreeCache, RefusesSurfacesWithoutAnInside)
{
	const Mesh sphere = makeSphereMesh(1, 3);
	EXPECT_TRUE(cachedTree(withoutTriangles(sphere, 1), few(), ""));
	const auto bowl = cachedTree(withoutTriangles(sphere, sphere.triangles.size() / 2), few(), "");
	ASSERT_FALSE(bowl);
	EXPECT_NE(bowl.error().message.find("inside"), std::string::npos) << bowl.error().message;
	EXPECT_TRUE(cachedTree(withoutTriangles(sphere, sphere.triangles.size() / 2), few(), "", 100));
	Mesh sheet;
	sheet.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.1}, {0, 1, 0}};
	sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
	EXPECT_FALSE(cachedTree(sheet, few(), ""));
}

TEST(TreeCache, ARefusalOfGroundThatWasClosedNamesWhatIsLeftToDo)
{
	// A slab of 4 m x 4 m that is 0.2 m deep, and a box that stands in it.
	Mesh ground = translated(makeBoxMesh({1, 1, 1}), {2, 0.9, 2});
	const auto first = static_cast<uint32_t>(ground.vertices.size());
	for (const Vec3& v : {Vec3{0, 0, 0}, Vec3{4, 0, 0}, Vec3{4, 0, 4}, Vec3{0, 0, 4}}) ground.vertices.push_back(v);
	ground.triangles.push_back({first, first + 2, first + 1});
	ground.triangles.push_back({first, first + 3, first + 2});
	BuildOptions options = few();
	options.repair = RepairMode::Ground;
	options.ground = {{1, 1}, 0.2};
	const auto refused = cachedTree(ground, options, "", 0.02);
	ASSERT_FALSE(refused);
	EXPECT_NE(refused.error().message.find("closed downwards, but parts of it pass through one another"), std::string::npos)
		<< refused.error().message;
	EXPECT_EQ(refused.error().message.find("if it is ground"), std::string::npos) << refused.error().message;
}

// The progress calls count the repairs of a mesh: each repair begins at 0.
TEST(TreeCache, RepairsAnOpenMeshOnceWhereItBuildsAndNeverWhereItLoads)
{
	const Folder folder;
	const Mesh open = withoutTriangles(makeBoxMesh({0.5, 0.3, 0.2}), 1);
	int repairs = 0;
	double last = 1;
	BuildOptions options = few();
	options.progress = [&](const char* stage, double fraction) {
		if (std::string(stage) != "repair") return true;
		if (fraction < last) ++repairs;
		last = fraction;
		return true;
	};
	const auto built = cachedTree(open, options, folder.path.string(), 100);
	ASSERT_TRUE(built);
	EXPECT_FALSE(built.value().fromCache);
	EXPECT_EQ(repairs, 1);
	EXPECT_EQ(encodeAsset(*built.value().tree), encodeAsset(buildTree(open, few()).value()));
	const auto loaded = cachedTree(open, options, folder.path.string(), 100);
	ASSERT_TRUE(loaded);
	EXPECT_TRUE(loaded.value().fromCache);
	EXPECT_EQ(encodeAsset(*built.value().tree), encodeAsset(*loaded.value().tree));
	// A tree that was built with a larger limit of doubt is refused if the limit is smaller.
	EXPECT_FALSE(cachedTree(open, options, folder.path.string(), 0.02));
	EXPECT_EQ(repairs, 1);
}

TEST(TreeCache, FindsTheDoubtAgainWhereItsFileIsMissingOrDamaged)
{
	const Folder folder;
	const Mesh open = withoutTriangles(makeBoxMesh({0.5, 0.3, 0.2}), 1);
	ASSERT_TRUE(cachedTree(open, few(), folder.path.string(), 100));
	std::filesystem::path file;
	for (const auto& entry : std::filesystem::directory_iterator(folder.path))
		if (entry.path().extension() == ".doubt") file = entry.path();
	ASSERT_FALSE(file.empty());
	for (const char* const text : {"", "0.01 or so", "-1", "nan"})
	{
		std::ofstream(file, std::ios::trunc) << text;
		EXPECT_FALSE(cachedTree(open, few(), folder.path.string(), 0.02)) << text;
	}
	std::filesystem::remove(file);
	EXPECT_FALSE(cachedTree(open, few(), folder.path.string(), 0.02));
	EXPECT_TRUE(std::filesystem::exists(file));
	EXPECT_TRUE(cachedTree(open, few(), folder.path.string(), 100).value().fromCache);
}

TEST(TreeWorker, BuildsEqualMeshesOnce)
{
	const Folder folder;
	TreeWorker worker(folder.path.string());
	const auto a = worker.build(makeBoxMesh({0.5, 0.3, 0.2}), few());
	const auto again = worker.build(makeBoxMesh({0.5, 0.3, 0.2}), few());
	const auto other = worker.build(makeBoxMesh({0.5, 0.3, 0.3}), few());
	EXPECT_EQ(a, again);
	EXPECT_NE(a, other);
	worker.finish();
	ASSERT_TRUE(a->isDone() && other->isDone());
	EXPECT_NEAR(a->tree()->volume, 8 * 0.5 * 0.3 * 0.2, 1e-12);
	EXPECT_NEAR(other->tree()->volume, 8 * 0.5 * 0.3 * 0.3, 1e-12);
	EXPECT_EQ(folder.files(), 2);
}

TEST(TreeWorker, TwoOfThemShareAFolder)
{
	const Folder folder;
	const int meshes = 2;
	std::vector<std::shared_ptr<const TreeOrder>> orders;
	{
		TreeWorker one(folder.path.string()), other(folder.path.string());
		for (int i = 0; i < meshes; ++i)
			for (TreeWorker* worker : {&one, &other}) orders.push_back(worker->build(makeBoxMesh({0.5, 0.3, 0.2 + 0.01 * i}), few()));
		one.finish();
		other.finish();
	}
	for (const auto& order : orders)
	{
		ASSERT_NE(order->tree(), nullptr) << order->error();
		EXPECT_EQ(order->note(), "");
	}
	EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path), {}), meshes);
	for (const auto& entry : std::filesystem::directory_iterator(folder.path))
		EXPECT_TRUE(loadAsset(entry.path().string())) << entry.path();
}

TEST(TreeWorker, LoadsFilesAndSaysWhyNot)
{
	const Folder folder;
	std::filesystem::create_directories(folder.path);
	const std::string path = (folder.path / "box.ist").string();
	ASSERT_TRUE(saveAsset(buildTree(makeBoxMesh({1, 1, 1}), few()).value(), path));
	TreeWorker worker;
	const auto good = worker.load(path), same = worker.load(path), missing = worker.load(path + "x");
	worker.finish();
	EXPECT_EQ(good, same);
	ASSERT_NE(good->tree(), nullptr);
	EXPECT_NEAR(good->tree()->volume, 8, 1e-12);
	EXPECT_EQ(missing->tree(), nullptr);
	EXPECT_NE(missing->error(), "");
}

TEST(TreeWorker, TriesAgainWhatFailed)
{
	const Folder folder;
	std::filesystem::create_directories(folder.path);
	const std::string path = (folder.path / "box.ist").string();
	TreeWorker worker;
	const auto early = worker.load(path);
	worker.finish();
	EXPECT_EQ(early->tree(), nullptr);
	ASSERT_TRUE(saveAsset(buildTree(makeBoxMesh({1, 1, 1}), few()).value(), path));
	const auto late = worker.load(path);
	worker.finish();
	EXPECT_NE(late->tree(), nullptr) << late->error();
	EXPECT_EQ(early->tree(), nullptr) << "what was said stays said";
	EXPECT_EQ(worker.load(path), late);
}

// The first order keeps the worker busy until the second one, which has no references left, has been dropped.
TEST(TreeWorker, DropsWhatNobodyWaitsFor)
{
	const Folder folder;
	std::atomic<bool> go{false};  // outlives the worker, because the worker's thread reads it
	TreeWorker worker(folder.path.string());
	BuildOptions slow = few();
	slow.progress = [&go](const char*, double) {
		while (!go) std::this_thread::yield();
		return true;
	};
	const auto first = worker.build(makeBoxMesh({0.5, 0.3, 0.2}), slow);
	worker.build(makeBoxMesh({0.5, 0.3, 0.3}), few()).reset();
	go = true;
	worker.finish();
	EXPECT_TRUE(first->isDone());
	EXPECT_EQ(folder.files(), 1);
}

TEST(TreeWorker, BreaksOffWhenItGoes)
{
	std::shared_ptr<const TreeOrder> running, waiting;
	std::atomic<bool> begun{false};  // outlives the worker, because the worker's thread writes it
	{
		TreeWorker worker;
		BuildOptions endless = few(1000000);
		endless.progress = [&begun](const char*, double) { return begun = true; };
		running = worker.build(makeTorusMesh(1, 0.3), endless);
		waiting = worker.build(makeBoxMesh({1, 1, 1}), few());
		while (!begun) std::this_thread::yield();
	}
	for (const auto& order : {running, waiting})
	{
		EXPECT_TRUE(order->isDone());
		EXPECT_EQ(order->tree(), nullptr);
		EXPECT_NE(order->error(), "");
	}
}
