// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/World/btISTSceneReport.h"
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace
{
std::shared_ptr<const ist::InnerSphereTree> treeOf(const ist::Vec3& half)
{
	ist::BuildOptions options;
	options.maxSpheres = 300;
	return std::make_shared<const ist::InnerSphereTree>(ist::buildTree(ist::makeBoxMesh(half), options).value());
}
const auto& cubeTree()
{
	static const auto tree = treeOf({0.5, 0.5, 0.5});
	return tree;
}

/// Parts of a world with a log.
struct Scene
{
	btISTWorld world;
	btBoxShape cube{btVector3(.5, .5, .5)}, other{btVector3(.5, .5, .5)};
	btISTAttachment attachment = world.attach(&cube, cubeTree()).value(), otherAttachment = world.attach(&other, cubeTree()).value();
	std::vector<std::unique_ptr<btRigidBody>> bodies;
	std::vector<std::string> lines;

	Scene()
	{
		world.setLog([this](const char* line) { lines.emplace_back(line); });
	}
	~Scene()
	{
		for (auto& b : bodies) world.bullet().removeRigidBody(b.get());
	}
	btRigidBody* add(btCollisionShape* shape, double mass, double y, bool hasInertia = true)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0 && hasInertia) shape->calculateLocalInertia(btScalar(mass), inertia);
		bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, shape, inertia));
		btRigidBody* body = bodies.back().get();
		body->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(y), 0)));
		body->setInterpolationWorldTransform(body->getWorldTransform());
		world.bullet().addRigidBody(body);
		return body;
	}
	void step(int count = 1)
	{
		for (int i = 0; i < count; ++i) ASSERT_FALSE(world.step(1.0 / 60));
	}
	uint64_t count(btISTWarning kind) const { return world.warnings()[kind].count; }
	int linesWith(const std::string& words) const
	{
		int found = 0;
		for (const std::string& line : lines) found += line.find(words) != std::string::npos;
		return found;
	}
};
}  // namespace

TEST(Warnings, NothingIsSaidOfAStackThatStands)
{
	Scene scene;
	scene.add(&scene.cube, 0, -.5);
	for (int i = 0; i < 3; ++i) scene.add(&scene.cube, 1, .5 + i)->setCcdMotionThreshold(.1f);
	scene.step(180);
	EXPECT_EQ(scene.world.warnings().count(), 0u);
	EXPECT_TRUE(scene.lines.empty()) << scene.lines.front();
	EXPECT_TRUE(btISTSceneReport::of(scene.world).warnings.empty());
}

// By its weight of 9.81 N on 1 m^2 the cube would sink by 98 mm, which is 0.29 of the thickness 2 V / S of a third of a metre.
TEST(Warnings, ADeepContactIsCountedSaidOnceAndReportedWithItsBodies)
{
	Scene scene;
	btRigidBody* floor = scene.add(&scene.other, 0, -.5);
	btRigidBody* body = scene.add(&scene.cube, 1, .5);
	ASSERT_FALSE(scene.world.materials().set(body, {100, 5}));
	scene.step(240);
	const btISTWarnings::Record& record = scene.world.warnings()[btISTWarning::Deep];
	EXPECT_GT(record.count, 100u);
	// It must be deep for 0.1 s. In the step in which it falls asleep it is found, but not solved.
	EXPECT_NEAR(double(record.count), double(scene.world.statistics().contactsTooDeep) - 6, 2);
	EXPECT_TRUE((record.bodyA == body && record.bodyB == floor) || (record.bodyA == floor && record.bodyB == body));
	EXPECT_NEAR(record.depth, .0981, .03);  // it falls into this depth and beyond
	EXPECT_NEAR(record.share, record.depth * 3, 1e-6);
	EXPECT_DOUBLE_EQ(record.k, 100);
	ASSERT_EQ(scene.lines.size(), 1u);
	EXPECT_EQ(scene.linesWith("deep contact"), 1) << scene.lines.front();
	EXPECT_EQ(scene.linesWith("its stiffness was set"), 1) << scene.lines.front();

	const btISTSceneReport report = btISTSceneReport::of(scene.world);
	ASSERT_EQ(report.warnings.size(), 1u);
	EXPECT_EQ(report.warnings[0].record.count, record.count);
	EXPECT_NE(report.text().find("warning: deep contact"), std::string::npos) << report.text();
	ASSERT_EQ(report.pairs.size(), 1u);
	EXPECT_NEAR(report.pairs[0].depthShare, 3 * report.pairs[0].depth, 1e-6);
	EXPECT_FALSE(report.pairs[0].advice.empty());
	EXPECT_NE(report.json().find("\"kind\":\"deep contact\""), std::string::npos);

	// The report names no body that is gone.
	scene.world.bullet().removeRigidBody(body);
	const btISTSceneReport later = btISTSceneReport::of(scene.world);
	ASSERT_EQ(later.warnings.size(), 1u);
	EXPECT_TRUE(later.warnings[0].nameA.empty() || later.warnings[0].nameB.empty());
	scene.world.bullet().addRigidBody(body);
}

TEST(Warnings, ABodyThatSinksThroughIsSaid)
{
	Scene scene;
	btBoxShape plate(btVector3(.5, .05f, .5));
	const btISTAttachment attached = scene.world.attach(&plate, treeOf({.5, .05, .5})).value();
	scene.add(&plate, 0, -.05);
	btRigidBody* body = scene.add(&scene.cube, 1, .5);
	ASSERT_FALSE(scene.world.materials().set(body, {10, 0}));
	scene.step(120);
	EXPECT_LT(double(body->getWorldTransform().getOrigin().y()), -1);
	EXPECT_GE(scene.count(btISTWarning::PassedThrough), 1u);
	EXPECT_EQ(scene.linesWith("passed through"), 1);
	for (auto& b : scene.bodies) scene.world.bullet().removeRigidBody(b.get());
	scene.bodies.clear();
}

// Bullet turns no body by more than half a turn in a step. The corners of a plate of 10 mm that nearly touches another then move by two
// metres, which is more than 64 queries can follow.
TEST(Warnings, APairThatTurnsTooFastIsSaid)
{
	const auto tree = treeOf({.5, .005, .5});
	btBoxShape lower(btVector3(.5, .005f, .5)), upper(btVector3(.5, .005f, .5));
	Scene scene;
	const btISTAttachment lowerTree = scene.world.attach(&lower, tree).value(), upperTree = scene.world.attach(&upper, tree).value();
	scene.add(&lower, 0, -.005);
	scene.add(&upper, 1, .006)->setAngularVelocity(btVector3(0, 1000, 0));
	scene.step();
	EXPECT_EQ(scene.count(btISTWarning::TooFast), 1u);
	EXPECT_EQ(scene.world.contacts().touchesMissed(), 1u);
	EXPECT_EQ(scene.linesWith("too fast"), 1);
}

TEST(Warnings, ABodyWithoutInertiaIsSaidUnlessItShallNotTurn)
{
	Scene scene;
	scene.add(&scene.cube, 1, 5, false)->setAngularFactor(btVector3(0, 0, 0));
	scene.step();
	EXPECT_EQ(scene.count(btISTWarning::NoInertia), 0u);
	btRigidBody* body = scene.add(&scene.cube, 1, 10, false);
	scene.step(64);
	EXPECT_EQ(scene.count(btISTWarning::NoInertia), 1u);
	EXPECT_EQ(scene.world.warnings()[btISTWarning::NoInertia].bodyA, body);
	EXPECT_EQ(scene.linesWith("calculateLocalInertia"), 1);
	// Of bodies, the count is that of the last look.
	scene.step(640);
	EXPECT_EQ(scene.count(btISTWarning::NoInertia), 1u);
}

TEST(Warnings, AShapeThatIsScaledLaterIsSaid)
{
	Scene scene;
	scene.add(&scene.cube, 1, 5);
	scene.step();
	EXPECT_EQ(scene.count(btISTWarning::Scaled), 0u);
	scene.cube.setLocalScaling(btVector3(2, 2, 2));
	scene.step(64);
	EXPECT_EQ(scene.count(btISTWarning::Scaled), 1u);
	EXPECT_EQ(scene.linesWith("attachScaled"), 1);
	scene.cube.setLocalScaling(btVector3(1, 1, 1));
	scene.step(64);
	EXPECT_EQ(scene.count(btISTWarning::Scaled), 0u);
}

/// An object in the world that is no body.
class PlacedObject
{
public:
	PlacedObject(Scene& scene, btCollisionShape& shape) : m_world(scene.world.bullet())
	{
		m_object.setCollisionShape(&shape);
		m_object.setWorldTransform(btTransform::getIdentity());
		m_world.addCollisionObject(&m_object);
	}
	~PlacedObject() { m_world.removeCollisionObject(&m_object); }

private:
	btDiscreteDynamicsWorld& m_world;
	btCollisionObject m_object;
};

// The box of a btGImpactMeshShape is turned inside out until its updateBound is called.
TEST(Warnings, AShapeWithoutABoxIsSaid)
{
	Scene scene;
	btTriangleMesh triangles;
	triangles.addTriangle(btVector3(0, 0, 0), btVector3(1, 0, 0), btVector3(0, 1, 1));
	btGImpactMeshShape shape(&triangles);
	const btISTAttachment attached = scene.world.attach(&shape, cubeTree()).value();
	const PlacedObject object(scene, shape);
	scene.step();
	EXPECT_EQ(scene.count(btISTWarning::NoBox), 1u);
	EXPECT_EQ(scene.linesWith("updateBound"), 1);
	shape.updateBound();
	scene.step(64);
	EXPECT_EQ(scene.count(btISTWarning::NoBox), 0u);
}

// A heightfield of equal heights has a flat box, with which the broad phase finds its pairs.
TEST(Warnings, AFlatBoxIsABox)
{
	Scene scene;
	const float heights[4] = {0, 0, 0, 0};
	btHeightfieldTerrainShape shape(2, 2, heights, btScalar(0), btScalar(0), 1, false);
	const btISTAttachment attached = scene.world.attach(&shape, cubeTree()).value();
	const PlacedObject object(scene, shape);
	scene.step();
	EXPECT_EQ(scene.count(btISTWarning::NoBox), 0u);
}

// A game that steps its world itself hears it too, and so does one that keeps a solver of its own.
TEST(Warnings, AGameThatStepsItsOwnWorldHearsThem)
{
	struct OwnSolver : btSequentialImpulseConstraintSolver
	{};
	for (const bool keepsSolver : {false, true})
	{
		btDefaultCollisionConfiguration configuration;
		btCollisionDispatcher dispatcher(&configuration);
		btDbvtBroadphase broadphase;
		btSequentialImpulseConstraintSolver solver;
		OwnSolver own;
		btDiscreteDynamicsWorld game(&dispatcher, &broadphase, keepsSolver ? &own : &solver, &configuration);
		btBoxShape cube(btVector3(.5, .5, .5));
		btRigidBody body(1, nullptr, &cube, btVector3(0, 0, 0));
		body.setCcdMotionThreshold(.1f);
		game.addRigidBody(&body);
		std::vector<std::string> lines;
		{
			btISTWorld ist(game);
			ASSERT_EQ(ist.solverRefusal().empty(), !keepsSolver) << ist.solverRefusal();
			ist.setLog([&](const char* line) { lines.emplace_back(line); });
			const btISTAttachment attached = ist.attach(&cube, cubeTree()).value();
			for (int i = 0; i < 70; ++i) game.stepSimulation(btScalar(1. / 60), 0);
			EXPECT_EQ(ist.warnings()[btISTWarning::NoInertia].count, 1u);
			EXPECT_EQ(ist.warnings()[btISTWarning::IgnoredCcd].count, keepsSolver ? 1u : 0u);
			EXPECT_EQ(lines.size(), keepsSolver ? 2u : 1u);
		}
		// The game's world goes on without it.
		game.stepSimulation(btScalar(1. / 60), 0);
		game.removeRigidBody(&body);
	}
}
