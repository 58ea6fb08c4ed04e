// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Registry/btISTTreeSource.h"

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"
#include "tests/unit/ISTCollision/Registry/BulletMesh.h"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>
#ifdef HAS_WORLD_IMPORTER
#include <BulletWorldImporter/btBulletWorldImporter.h>
#endif

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <unistd.h>

namespace
{
btTransform at(double x, double y, double z)
{
	return btTransform(btQuaternion::getIdentity(), btVector3(btScalar(x), btScalar(y), btScalar(z)));
}

/// A game that registers GImpact first and then this library.
struct Game
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	std::unique_ptr<btDiscreteDynamicsWorld> world = std::make_unique<btDiscreteDynamicsWorld>(
		&dispatcher, &broadphase, &solver, &configuration);
	btISTRegistration registration;
	std::vector<std::unique_ptr<btRigidBody>> bodies;

	Game()
	{
		btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
		registration = btISTCollisionAlgorithm::registerAlgorithm(&dispatcher, world->getPairCache());
	}
	~Game()
	{
		for (auto& body : bodies) world->removeRigidBody(body.get());
		world.reset();
	}
	btRigidBody* add(btCollisionShape* shape, double mass, const btTransform& pose)
	{
		bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, shape, btVector3(mass > 0, mass > 0, mass > 0)));
		bodies.back()->setWorldTransform(pose);
		bodies.back()->setActivationState(DISABLE_DEACTIVATION);
		world->addRigidBody(bodies.back().get());
		return bodies.back().get();
	}
	void detect() { world->performDiscreteCollisionDetection(); }
	/// Overlap volume of the only contact [m^3]; -1 when there is not exactly one.
	double onlyVolume()
	{
		const auto& contacts = registration.store().contacts();
		return contacts.size() == 1 ? contacts[0]->total.volume : -1;
	}
};

struct GImpactBox : BulletMesh, btGImpactMeshShape
{
	explicit GImpactBox(const ist::Vec3& half, double scaling = 1)
		: BulletMesh(ist::makeBoxMesh(half)),
		  btGImpactMeshShape(BulletMesh::interface())
	{
		setLocalScaling(btVector3(btScalar(scaling), btScalar(scaling), btScalar(scaling)));
		updateBound();
	}
};

btISTTreeSettings few()
{
	btISTTreeSettings settings;
	settings.build.maxSpheres = 100;
	settings.cacheFolder = TREE_FOLDER;
	return settings;
}

/// The names that Bullet's importers provide, for two shapes and a body.
struct NamedShapes
{
	std::map<std::string, btCollisionShape*> shapes;
	std::map<std::string, btRigidBody*> bodies;
	btCollisionShape* getCollisionShapeByName(const char* name) { return shapes.count(name) ? shapes[name] : nullptr; }
	btRigidBody* getRigidBodyByName(const char* name) { return bodies.count(name) ? bodies[name] : nullptr; }
};

struct Folder
{
	std::filesystem::path path = std::filesystem::path(testing::TempDir()) /
		("ist_source_" + std::to_string(sizeof(btScalar)) + std::to_string(::getpid()) +
			testing::UnitTest::GetInstance()->current_test_info()->name());
	Folder() { std::filesystem::create_directories(path); }
	~Folder() { std::filesystem::remove_all(path); }
};
}  // namespace

// In flat contact away from side faces, a cube of edge 1 that is 0.1 m deep in the plane overlaps it by 0.1 m^3.
TEST(btISTTreeSource, SwapsTheTreeInBetweenStepsAndBulletsContactGoesOnUntilThen)
{
	Game game;
	GImpactBox cube({0.5, 0.5, 0.5});
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	game.add(&plane, 0, at(0, 0, 0));
	game.add(&cube, 1, at(1000, 0.4, 3));
	btISTTreeSource trees(game.registration.registry(), few());
	const btISTPendingAttachment attachment = trees.attach(&cube);
	EXPECT_TRUE(attachment.isPending());
	EXPECT_EQ(trees.pending(), 1);
	game.detect();
	EXPECT_EQ(game.onlyVolume(), -1);
	EXPECT_GT(game.dispatcher.getNumManifolds(), 0) << "GImpact's own contact";
	EXPECT_EQ(trees.finish(), 1);
	EXPECT_TRUE(attachment.isAttached());
	EXPECT_EQ(attachment.error(), "");
	EXPECT_EQ(trees.pending(), 0);
	game.detect();
	EXPECT_NEAR(game.onlyVolume(), 0.1, 0.005);
}

namespace
{
constexpr int kPoints = 9;

/// Heights of a grid of points 1 m apart.
struct Heights
{
	std::vector<float> values;
	float lowest = 0, highest = 0;

	Heights()
	{
		for (int j = 0; j < kPoints; ++j)
			for (int i = 0; i < kPoints; ++i) values.push_back(0.25f * float((i * 5 + j * 3 + i * j) % 7));
		lowest = *std::min_element(values.begin(), values.end());
		highest = *std::max_element(values.begin(), values.end());
	}
	double at(int i, int j) const { return double(values[size_t(j * kPoints + i)]); }
	/// Volume between the surface and a plane below its lowest point [m^3]. The squares are parted from (1, 0) to (0, 1).
	double volume(double depth) const
	{
		double sum = 0;
		for (int j = 0; j + 1 < kPoints; ++j)
			for (int i = 0; i + 1 < kPoints; ++i)
				sum += (at(i, j) + 2 * at(i + 1, j) + 2 * at(i, j + 1) + at(i + 1, j + 1)) / 6 - double(lowest) + depth;
		return sum;
	}
	btHeightfieldTerrainShape shape(int up) const
	{
		return {kPoints, kPoints, values.data(), btScalar(lowest), btScalar(highest), up, false};
	}
};

ist::Mesh openGround()
{
	ist::Mesh box = ist::makeBoxMesh({2, 1, 2}), top{box.vertices, {}};
	for (const auto& t : box.triangles)
		if (box.vertices[t[0]].y > 0 && box.vertices[t[1]].y > 0 && box.vertices[t[2]].y > 0) top.triangles.push_back(t);
	return top;
}
}  // namespace

TEST(btISTTreeSource, AHeightfieldBecomesGroundAlongItsOwnAxis)
{
	const Heights heights;
	for (const int up : {0, 1, 2})
	{
		Game game;
		btHeightfieldTerrainShape terrain = heights.shape(up);
		btISTTreeSource trees(game.registration.registry(), few());
		const btISTPendingAttachment attachment = trees.attach(&terrain);
		trees.finish();
		ASSERT_TRUE(attachment.isAttached()) << attachment.error();
		EXPECT_NEAR(attachment.tree()->volume, heights.volume(0.1 * (kPoints - 1)), 1e-4);
		const ist::Vec3 size = attachment.tree()->box.size();
		EXPECT_NEAR(size[up], double(heights.highest - heights.lowest) + 0.1 * (kPoints - 1), 1e-5);
	}
}

// A box that is 0.1 m deep in level ground overlaps it by 0.1 m times its base.
TEST(btISTTreeSource, OpenTrianglesBecomeGroundOnRequest)
{
	Game game;
	BulletMesh mesh(openGround());
	btBvhTriangleMeshShape ground(mesh.interface(), true);
	btBoxShape box(btVector3(btScalar(0.3), btScalar(0.3), btScalar(0.3)));
	game.add(&ground, 0, at(0, -1, 0));
	game.add(&box, 1, at(0.3, 0.2, 0.1));
	btISTTreeSource trees(game.registration.registry(), few());
	const btISTPendingAttachment closed = trees.attach(&ground);
	trees.finish();
	EXPECT_NE(closed.error().find("ground that faces y"), std::string::npos) << closed.error();
	const btISTPendingAttachment wrong = trees.attachGround(&ground, 1, {2, 1}), tooShallow = trees.attachGround(&ground, -1);
	trees.finish();
	EXPECT_NE(wrong.error().find("it faces y"), std::string::npos) << wrong.error();
	EXPECT_EQ(tooShallow.isAttached(), false);
	const btISTPendingAttachment attachment = trees.attachGround(&ground, 1);
	trees.finish();
	ASSERT_TRUE(attachment.isAttached()) << attachment.error();
	EXPECT_NEAR(attachment.tree()->volume, 16, 1e-4);
	game.detect();
	EXPECT_NEAR(game.onlyVolume(), 0.1 * 0.6 * 0.6, 1e-3 * 0.1 * 0.6 * 0.6);
}

// Trees of one surface with other depths are others in the folder.
TEST(btISTTreeSource, TheFolderKeepsGroundByItsDepth)
{
	const Folder folder;
	btISTTreeSettings settings = few();
	settings.cacheFolder = folder.path.string();
	BulletMesh mesh(openGround());
	for (const double depth : {1.0, 2.0, 1.0})
	{
		Game game;
		btBvhTriangleMeshShape ground(mesh.interface(), true);
		btISTTreeSource trees(game.registration.registry(), settings);
		const btISTPendingAttachment attachment = trees.attachGround(&ground, depth);
		trees.finish();
		ASSERT_TRUE(attachment.isAttached()) << attachment.error();
		EXPECT_NEAR(attachment.tree()->volume, 16 * depth, 1e-4);
	}
	EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path), {}), 4) << "two trees and what was doubtful about them";
}

TEST(btISTTreeSource, TheTreeIsThatOfTheScaledTriangles)
{
	Game game;
	GImpactBox cube({0.25, 0.25, 0.25}, 2);
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	game.add(&plane, 0, at(0, 0, 0));
	game.add(&cube, 1, at(-2, 0.4, 3));
	btISTTreeSource trees(game.registration.registry(), few());
	const btISTPendingAttachment attachment = trees.attach(&cube);
	EXPECT_EQ(trees.finish(), 1);
	EXPECT_NEAR(attachment.tree()->volume, 1, 1e-5);
	game.detect();
	EXPECT_NEAR(game.onlyVolume(), 0.1, 0.005);
	cube.setLocalScaling(btVector3(1, 1, 1));
	game.detect();
	EXPECT_EQ(game.onlyVolume(), 0) << "Bullet's contact, with no claim of ours";
	cube.setLocalScaling(btVector3(2, 2, 2));
	game.detect();
	EXPECT_NEAR(game.onlyVolume(), 0.1, 0.005);
}

TEST(btISTTreeSource, AShapeThatIsScaledMeanwhileKeepsBulletsContact)
{
	Game game;
	GImpactBox cube({0.5, 0.5, 0.5});
	btISTTreeSource trees(game.registration.registry(), few());
	const btISTPendingAttachment attachment = trees.attach(&cube);
	cube.setLocalScaling(btVector3(2, 1, 1));
	EXPECT_EQ(trees.finish(), 0);
	EXPECT_NE(attachment.error().find("scaling"), std::string::npos);
	EXPECT_EQ(game.registration.registry().size(), 0);
}

TEST(btISTTreeSource, FindsEveryGImpactMeshOfAWorldOnce)
{
	Game game;
	GImpactBox cube({0.5, 0.5, 0.5}), same({0.5, 0.5, 0.5}), child({0.25, 0.5, 0.5}), has({1, 0.5, 0.5});
	btBoxShape stock(btVector3(1, 1, 1));
	btCompoundShape compound;
	compound.addChildShape(at(1, 0, 0), &child);
	compound.addChildShape(at(-1, 0, 0), &stock);
	btISTTreeSource trees(game.registration.registry(), few());
	auto already = trees.attach(&has);
	EXPECT_EQ(trees.finish(), 1);
	int x = 0;
	for (btCollisionShape* shape :
		{static_cast<btCollisionShape*>(&cube), static_cast<btCollisionShape*>(&cube), static_cast<btCollisionShape*>(&same),
			static_cast<btCollisionShape*>(&compound), static_cast<btCollisionShape*>(&stock), static_cast<btCollisionShape*>(&has)})
		game.add(shape, 1, at(10 * x++, 0, 0));
	auto all = trees.attachGImpact(*game.world);
	ASSERT_EQ(all.size(), 3u);
	EXPECT_TRUE(trees.attachGImpact(*game.world).empty()) << "they wait already";
	EXPECT_EQ(trees.finish(), 3);
	EXPECT_EQ(all[0].shape(), &cube);
	EXPECT_EQ(all[1].shape(), &same);
	EXPECT_EQ(all[2].shape(), &child);
	EXPECT_EQ(all[0].tree(), all[1].tree()) << "equal triangles, one tree";
	EXPECT_NE(all[0].tree(), all[2].tree());
	EXPECT_TRUE(trees.attachGImpact(*game.world).empty());
	all.clear();
	EXPECT_EQ(game.registration.registry().size(), 1);
}

TEST(btISTTreeSource, SaysWhyAShapeGetsNoTree)
{
	btISTRegistry registry;
	btISTTreeSource trees(registry, few());
	btSphereShape sphere(1);
	GImpactBox cube({0.5, 0.5, 0.5});
	BulletMesh open(ist::makeBoxMesh({1, 1, 1}));
	ist::Mesh withoutFaces = open.mesh();
	withoutFaces.triangles.resize(6);
	const BulletMesh room(withoutFaces);
	btBvhTriangleMeshShape surface(room.interface(), true);
	NamedShapes importer;

	EXPECT_NE(trees.attach(nullptr).error(), "");
	EXPECT_NE(trees.attach(&sphere).error(), "");
	EXPECT_NE(trees.attach(importer, "nobody").error().find("nobody"), std::string::npos);
	const auto missing = trees.attachAsset(&sphere, "/nowhere/sphere.ist"), noInside = trees.attach(&surface), good = trees.attach(&cube);
	EXPECT_NE(trees.attach(&cube).error(), "") << "it waits already";
	EXPECT_EQ(trees.finish(), 1);
	EXPECT_NE(missing.error().find("sphere.ist"), std::string::npos);
	EXPECT_NE(noInside.error().find("inside"), std::string::npos);
	EXPECT_TRUE(good.isAttached());
	EXPECT_NE(trees.attach(&cube).error(), "") << "it has one";
	EXPECT_EQ(trees.pending(), 0);
}

TEST(btISTTreeSource, HandlesAndSourceMayGoInAnyOrder)
{
	btISTRegistry registry;
	GImpactBox cube({0.5, 0.5, 0.5}), late({0.5, 0.5, 0.25});
	auto doomed = std::make_unique<GImpactBox>(ist::Vec3{0.5, 0.25, 0.25});
	auto trees = std::make_unique<btISTTreeSource>(registry, few());
	auto kept = trees->attach(&cube), dropped = trees->attach(doomed.get());
	dropped.detach();
	doomed.reset();
	EXPECT_EQ(trees->finish(), 1);
	btISTPendingAttachment waiting = trees->attach(&late);
	trees.reset();
	EXPECT_FALSE(waiting.isPending());
	EXPECT_NE(waiting.error(), "");
	EXPECT_TRUE(kept.isAttached());
	btISTPendingAttachment moved = std::move(kept);
	EXPECT_TRUE(moved.isAttached());
	EXPECT_FALSE(kept.isAttached());
	moved.detach();
	EXPECT_EQ(registry.size(), 0);
}

TEST(btISTTreeSource, KeepsItsTreesFromOneRunToTheNext)
{
	const Folder folder;
	btISTTreeSettings settings = few();
	settings.cacheFolder = (folder.path / "made when needed").string();
	std::filesystem::file_time_type written;
	for (int run = 0; run < 2; ++run)
	{
		btISTRegistry registry;
		GImpactBox cube({0.5, 0.5, 0.5});
		btISTTreeSource trees(registry, settings);
		const auto attachment = trees.attach(&cube);
		EXPECT_EQ(trees.finish(), 1);
		EXPECT_EQ(attachment.note(), "");
		const auto file = std::filesystem::directory_iterator(settings.cacheFolder)->path();
		if (run == 0) written = std::filesystem::last_write_time(file);
		EXPECT_EQ(std::filesystem::last_write_time(file), written) << "not built again";
	}
}

TEST(btISTTreeSource, AttachesAFolderOfAssetsByName)
{
	const Folder folder;
	ist::BuildOptions options;
	options.maxSpheres = 10;
	const ist::InnerSphereTree tree = ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value();
	for (const char* name : {"crate", "stone", "unused"}) ASSERT_TRUE(ist::saveAsset(tree, (folder.path / name).string() + ".ist"));
	btBoxShape crate(btVector3(1, 1, 1)), stone(btVector3(1, 1, 1));
	btRigidBody body(0, nullptr, &stone);
	NamedShapes importer{{{"crate", &crate}, {"other", &stone}}, {{"stone", &body}}};
	btISTRegistry registry;
	btISTTreeSource trees(registry, few());
	const auto attached = trees.attachFolder(importer, folder.path.string());
	EXPECT_EQ(trees.finish(), 2);
	ASSERT_EQ(attached.size(), 2u);
	EXPECT_EQ(attached[0].shape(), &crate);
	EXPECT_EQ(attached[1].shape(), &stone);
	EXPECT_TRUE(trees.attachFolder(importer, "/nowhere").empty());
}

#ifdef HAS_WORLD_IMPORTER
// A scene is saved with names, as a level editor does, and loaded by another run of the program. The shape is a hull, because the
// importer that Debian ships omits GImpact bodies.
TEST(btISTTreeSource, AttachesByNameAfterLoadingABulletFile)
{
	const Folder folder;
	const std::string file = (folder.path / "level.bullet").string();
	{
		Game editor;
		btConvexHullShape cube;
		for (int corner = 0; corner < 8; ++corner)
			cube.addPoint(btVector3(corner & 1 ? .5f : -.5f, corner & 2 ? .5f : -.5f, corner & 4 ? .5f : -.5f));
		btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
		editor.add(&plane, 0, at(0, 0, 0));
		btRigidBody* body = editor.add(&cube, 1, at(3, 0.4, 0));
		btDefaultSerializer serializer;
		serializer.registerNameForPointer(&cube, "cube of the editor");
		serializer.registerNameForPointer(body, "its body");
		editor.world->serialize(&serializer);
		FILE* out = std::fopen(file.c_str(), "wb");
		ASSERT_NE(out, nullptr);
		std::fwrite(serializer.getBufferPointer(), size_t(serializer.getCurrentBufferSize()), 1, out);
		std::fclose(out);
	}
	ist::BuildOptions options;
	options.maxSpheres = 100;
	const ist::InnerSphereTree tree = ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value();
	for (const std::string name : {"cube of the editor", "its body"})
	{
		const std::filesystem::path assets = folder.path / ("assets of " + name);
		std::filesystem::create_directories(assets);
		const std::string asset = (assets / name).string() + ".ist";
		ASSERT_TRUE(ist::saveAsset(tree, asset));
		ASSERT_TRUE(ist::saveAsset(tree, (assets / "nobody.ist").string()));
		for (const std::string way : {"attach", "attachAsset", "attachFolder"})
		{
			Game game;
			btBulletWorldImporter importer(game.world.get());
			ASSERT_TRUE(importer.loadFile(file.c_str()));
			{
				btISTTreeSource trees(game.registration.registry(), few());
				std::vector<btISTPendingAttachment> cube;
				if (way == "attachFolder") cube = trees.attachFolder(importer, assets.string());
				else
					cube.push_back(
						way == "attach" ? trees.attach(importer, name.c_str()) : trees.attachAsset(importer, name.c_str(), asset));
				ASSERT_EQ(cube.size(), 1u) << way << ", " << name;
				EXPECT_EQ(trees.finish(), 1) << way << ", " << name << ": " << cube[0].error();
				game.detect();
				EXPECT_NEAR(game.onlyVolume(), 0.1, 0.005) << way << ", " << name;
			}
			importer.deleteAllData();
		}
	}
}
#endif

TEST(btISTTreeSource, OrdersATreeWhenSomethingComesNear)
{
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	btSphereShape other(btScalar(.5));
	GImpactBox box({.5, .5, .5});
	// The places: far from everything, near the plane, near the sphere.
	for (const auto& [place, near] : {std::pair(at(300, 50, 0), false), std::pair(at(300, 1.4, 0), true), std::pair(at(1.9, 50, 0), true)})
	{
		Game game;
		game.add(&plane, 0, at(0, 0, 0));
		game.add(&other, 1, at(0, 50, 0));
		btRigidBody* body = game.add(&box, 1, place);
		const auto moveTo = [&](const btTransform& to) {
			body->setWorldTransform(to);
			body->setInterpolationWorldTransform(to);  // Bullet's boxes use this transform, too
			game.detect();
		};
		moveTo(place);
		btISTTreeSource source(game.registration.registry(), few());
		source.orderWhenNear(game.world.get());
		const btISTPendingAttachment pending = source.attach(&box);
		source.update();
		EXPECT_TRUE(pending.isPending() || pending.isAttached()) << pending.error();
		EXPECT_EQ(source.waitingForNeighbours(), near ? 0 : 1);
		if (near) continue;
		moveTo(at(1.9, 50, 0));
		source.update();
		EXPECT_EQ(source.waitingForNeighbours(), 0);
		source.finish();
		EXPECT_TRUE(pending.isAttached()) << pending.error();
	}
}

/// Counts the requests for objects nearby.
struct CountingBroadphase : btDbvtBroadphase
{
	int asked = 0;
	void aabbTest(const btVector3& lower, const btVector3& upper, btBroadphaseAabbCallback& callback) override
	{
		++asked;
		btDbvtBroadphase::aabbTest(lower, upper, callback);
	}
};

TEST(btISTTreeSource, LooksAtEachObjectOnceHoweverManyShapesWait)
{
	Game game;
	CountingBroadphase broadphase;
	btCollisionWorld world(&game.dispatcher, &broadphase, &game.configuration);
	std::vector<std::unique_ptr<GImpactBox>> boxes;
	std::vector<std::unique_ptr<btCollisionObject>> objects;
	constexpr int kShapes = 20;
	for (int i = 0; i < kShapes; ++i) boxes.push_back(std::make_unique<GImpactBox>(ist::Vec3{.5, .5, .5}));
	btCompoundShape both;
	both.addChildShape(at(0, 0, 0), boxes[0].get());
	both.addChildShape(at(2, 0, 0), boxes[1].get());
	for (int i = 1; i < kShapes; ++i)
	{
		objects.push_back(std::make_unique<btCollisionObject>());
		objects.back()->setCollisionShape(i == 1 ? static_cast<btCollisionShape*>(&both) : boxes[size_t(i)].get());
		objects.back()->setWorldTransform(at(20 * i, 0, 0));
		world.addCollisionObject(objects.back().get());
	}
	btISTTreeSource source(game.registration.registry(), few());
	source.orderWhenNear(&world);
	std::vector<btISTPendingAttachment> pending;
	for (const auto& box : boxes) pending.push_back(source.attach(box.get()));
	source.update();
	EXPECT_EQ(broadphase.asked, kShapes - 1);
	EXPECT_EQ(source.waitingForNeighbours(), kShapes);
	// The compound approaches the last object, so three shapes are near something.
	objects.front()->setWorldTransform(at(20 * (kShapes - 1) - 1.5, 0, 0));
	world.updateAabbs();
	source.update();
	EXPECT_EQ(source.waitingForNeighbours(), kShapes - 3);
	for (const auto& object : objects) world.removeCollisionObject(object.get());
}

TEST(btISTTreeSource, LevelsAreTheWorkersToo)
{
	const Folder folder;
	const std::string path = (folder.path / "box.ist").string();
	ist::BuildOptions options;
	options.maxSpheres = 300;
	ASSERT_TRUE(ist::saveAsset(ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value(), path));
	for (const bool before : {false, true})
	{
		GImpactBox one({.5, .5, .5}), two({.5, .5, .5});
		btBoxShape box(btVector3(.5, .5, .5));
		Game game;
		btISTRegistry& registry = game.registration.registry();
		btISTTreeSettings settings;
		settings.build = options;
		btISTTreeSource source(registry, settings);
		if (before) registry.keepLevels();
		const auto first = source.attach(&one), second = source.attach(&two), file = source.attachAsset(&box, path);
		if (!before) registry.keepLevels();
		EXPECT_EQ(source.finish(), 3) << first.error() << second.error() << file.error();
		EXPECT_EQ(first.tree(), second.tree());
		for (const btISTPendingAttachment* attached : {&first, &second, &file})
		{
			EXPECT_FALSE(attached->tree()->levels.empty());
			EXPECT_EQ(registry.find(attached->shape()), attached->tree()) << "the registry had nothing to add, on the thread of the world";
		}
	}
}

TEST(btISTTreeSource, FinishOrdersWhatIsFarToo)
{
	GImpactBox box({.5, .5, .5});
	Game game;
	game.add(&box, 1, at(0, 0, 0));
	btISTTreeSource source(game.registration.registry(), few());
	source.orderWhenNear(game.world.get());
	const btISTPendingAttachment pending = source.attach(&box);
	source.update();
	EXPECT_EQ(source.waitingForNeighbours(), 1);
	EXPECT_EQ(source.pending(), 1);
	EXPECT_EQ(source.finish(), 1);
	EXPECT_TRUE(pending.isAttached());
	EXPECT_EQ(source.waitingForNeighbours(), 0);
}

TEST(btISTTreeSource, NeverOrdersWhatGoesBeforeAnythingIsNear)
{
	GImpactBox box({.5, .5, .5});
	Game game;
	game.add(&box, 1, at(0, 0, 0));
	btISTTreeSource source(game.registration.registry(), few());
	source.orderWhenNear(game.world.get());
	btISTPendingAttachment pending = source.attach(&box);
	pending.detach();
	EXPECT_EQ(source.finish(), 0);
	EXPECT_EQ(source.pending(), 0);
	source.orderWhenNear(nullptr);
	pending = source.attach(&box);
	EXPECT_EQ(source.waitingForNeighbours(), 0);
	EXPECT_EQ(source.finish(), 1);
}
