// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Registry/btISTTreeSource.h"
#include "DeviceBridge/Bullet/BulletContactSource.h"
#include "DeviceBridge/Bullet/BulletShapeParts.h"
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/DeviceBridge/Bullet/DecoupledRig.h"

#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btCapsuleShape.h"
#include "BulletCollision/CollisionShapes/btCompoundShape.h"
#include "BulletCollision/CollisionShapes/btConeShape.h"
#include "BulletCollision/CollisionShapes/btConvexHullShape.h"
#include "BulletCollision/CollisionShapes/btCylinderShape.h"
#include "BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"

#include <gtest/gtest.h>

#if defined(__GLIBC__)
#include <malloc.h>
#include <sys/resource.h>
#endif

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

using namespace devicebridge;
using ist::Vec3;

// The oracle of these tests is one-thread mode: the same tool and the same bodies in a world that steps in every tick and whose own
// algorithm and solver find the force.

namespace
{
/// A shape, and what it is made of. All but the cone are 30 mm high above their origin.
struct Shape
{
	std::string name;
	std::vector<std::unique_ptr<btCollisionShape>> parts;
	btCollisionShape* shape = nullptr;
	Vec3 top{0, 0.03, 0};  ///< where the tool presses

	template <class T, class... Arguments> T& make(Arguments... arguments)
	{
		parts.push_back(std::make_unique<T>(arguments...));
		return static_cast<T&>(*parts.back());
	}
};

Shape shapeOf(const std::string& name)
{
	Shape s;
	s.name = name;
	const btScalar high = btScalar(0.03);
	if (name == "box") s.shape = &s.make<btBoxShape>(btVector3(btScalar(0.1), high, btScalar(0.05)));
	if (name == "sphere") s.shape = &s.make<btSphereShape>(high);
	if (name == "capsule") s.shape = &s.make<btCapsuleShapeX>(high, btScalar(0.15));
	if (name == "cylinder") s.shape = &s.make<btCylinderShapeX>(btVector3(btScalar(0.1), high, high));
	if (name == "upright cylinder") s.shape = &s.make<btCylinderShape>(btVector3(btScalar(0.1), high, btScalar(0.1)));
	if (name == "cone")  // pressed half way up its side, whose slope puts the first touch lower
		s.shape = &s.make<btConeShape>(btScalar(0.12), btScalar(0.1)), s.top = {0.06, 0.006, 0};
	if (name.find("compound") == 0)
	{
		auto& inner = s.make<btCompoundShape>();
		auto& box = s.make<btBoxShape>(btVector3(btScalar(0.05), high, btScalar(0.05)));
		inner.addChildShape(placed(-0.05, 0, 0), &box);
		if (name == "compound of boxes") inner.addChildShape(placed(0.05, 0, 0), &box);
		else inner.addChildShape(placed(0.05, 0, 0), &s.make<btCylinderShape>(btVector3(btScalar(0.05), high, btScalar(0.05))));
		s.shape = &inner;
		s.top = {-0.02, 0.03, 0};
		if (name == "compound in a compound")
		{
			auto& outer = s.make<btCompoundShape>();
			const btQuaternion turn(btVector3(0, 1, 0), btScalar(0.7));
			outer.addChildShape(btTransform(turn, btVector3(btScalar(0.01), 0, 0)), &inner);
			s.shape = &outer;
		}
	}
	return s;
}

const char* const kShapes[] = {"box", "sphere", "capsule", "cylinder", "upright cylinder", "cone", "compound", "compound in a compound"};

/// The tool: a ball of 20 mm, or a compound of two.
struct Tool
{
	btSphereShape ball{btScalar(kBallRadius)};
	btCompoundShape pair;
	bool two;

	explicit Tool(bool isCompound) : two(isCompound)
	{
		for (const double x : {-0.015, 0.015}) pair.addChildShape(placed(x, 0, 0), &ball);
	}
	btCollisionShape& shape() { return two ? static_cast<btCollisionShape&>(pair) : ball; }
};

/// Half a second in which bodies settle, down by 3 mm from the first touch within 0.2 s, half a second of rest, then along x at 0.1 m/s.
ist::Twist pressAndSlide(double time)
{
	const double t = time - 0.5005;  // between two ticks
	if (t <= 0) return {};
	if (t <= 0.2) return {{0, -0.005 / 0.2, 0}, {}};
	return {{t > 0.7 && t <= 0.9 ? 0.1 : 0, 0, 0}, {}};
}
constexpr int kTicks = 1400, kRestTicks = 1200;

/// What the hand feels in each tick.
using Forces = std::vector<Vec3>;

Vec3 startAbove(const Shape& s) { return s.top + Vec3{0, kBallRadius + 0.002, 0}; }

std::unique_ptr<btRigidBody> bodyOf(btCollisionShape& shape, double mass, const Vec3& where)
{
	btVector3 inertia(0, 0, 0);
	if (mass > 0) shape.calculateLocalInertia(btScalar(mass), inertia);
	auto body = std::make_unique<btRigidBody>(btScalar(mass), nullptr, &shape, inertia);
	body->setWorldTransform(btTransform(btQuaternion::getIdentity(), bullet(where)));
	body->setInterpolationWorldTransform(body->getWorldTransform());
	body->setFriction(btScalar(0.5));
	body->forceActivationState(DISABLE_DEACTIVATION);
	return body;
}

const auto& tableTree()
{
	static const auto tree = keptTree(ist::makeBoxMesh({0.2, 0.05, 0.2}), "table_400mm.ist");
	return tree;
}
const auto& slabTree()  // of the shape "box"
{
	static const auto tree = keptTree(ist::makeBoxMesh({0.1, 0.03, 0.05}), "slab_200mm.ist");
	return tree;
}

struct Case
{
	double mass = 0;  ///< above 0: the body lies on a table under gravity. The table has a tree, because Bullet's own contact lets
					  ///< cylinders wobble [kg]
	bool compoundTool = false;
	double dissipation = 2;  ///< [s/m]
	double stiffness = 2e7;  ///< [Pa/m]; 0: not set
	bool treeOfTool = true;  ///< otherwise the body has a tree and the tool none
	double rate = 60;        ///< steps of the world in decoupled mode [Hz]
	ContactThreading threading = ContactThreading::InHapticThread;
};

/// The trees of a case, and the table.
struct Attached
{
	btBoxShape tableShape{btVector3(btScalar(0.2), btScalar(0.05), btScalar(0.2))};
	std::vector<btISTAttachment> trees;

	Attached(btISTWorld& world, const Shape& s, Tool& tool, const Case& c)
	{
		trees.push_back(std::move(world.attach(&tableShape, tableTree())).value());
		if (c.treeOfTool) trees.push_back(std::move(world.attach(&tool.ball, ballTree())).value());
		else trees.push_back(std::move(world.attach(s.shape, slabTree())).value());
	}
};

Forces inOneThread(const Shape& s, const Case& c)
{
	const double mass = c.mass;
	Tool tool(c.compoundTool);
	btISTWorld world;
	world.setGravity(btVector3(0, btScalar(mass > 0 ? -9.81 : 0), 0));
	Attached attached(world, s, tool, c);
	const std::unique_ptr<btRigidBody> table = bodyOf(attached.tableShape, 0, {0, -0.08, 0}), body = bodyOf(*s.shape, mass, {});
	btRigidBody held(Hand::info(tool.shape(), startAbove(s)));
	for (const btRigidBody* b : {table.get(), body.get(), &held})
		if (world.materials().set(b, {c.stiffness, c.dissipation})) throw std::runtime_error("material");
	if (mass > 0) world.bullet().addRigidBody(table.get());
	world.bullet().addRigidBody(body.get());
	world.bullet().addRigidBody(&held);
	Forces forces = forcesInOneThread(world, held, startAbove(s), pressAndSlide, kTicks);
	world.bullet().removeRigidBody(&held);
	world.bullet().removeRigidBody(body.get());
	if (mass > 0) world.bullet().removeRigidBody(table.get());
	return forces;
}

Forces decoupled(const Shape& s, const Case& c)
{
	const double mass = c.mass;
	Tool tool(c.compoundTool);
	DecoupledRig rig(c.rate, {0, mass > 0 ? -9.81 : 0, 0});
	Attached attached(rig.world, s, tool, c);
	if (mass > 0) rig.add(attached.tableShape, 0, {0, -0.08, 0}, 0.5);
	rig.add(*s.shape, mass, {}, 0.5);
	for (const auto& b : rig.bodies)
		if (rig.world.materials().set(b.get(), {c.stiffness, c.dissipation})) throw std::runtime_error("material");
	BulletDecoupledSettings settings = handSettings();
	settings.topology = c.threading;
	rig.hands.push_back(std::make_unique<Hand>(rig.world, tool.shape(), rig.clock, startAbove(s), settings));
	Hand& hand = *rig.hands.back();
	if (rig.world.materials().set(&hand.body, {c.stiffness, c.dissipation})) throw std::runtime_error("material");
	rig.coupling.add(hand.source);
	hand.script = pressAndSlide;
	Forces forces;
	rig.afterTick = [&] { forces.push_back(hand.step.coupling.force); };
	rig.run(1e-3 * kTicks);
	EXPECT_TRUE(rig.coupling.unfelt().empty()) << rig.coupling.unfeltReport();
	EXPECT_EQ(hand.source.statistics().refusedQueries, 0U);
	EXPECT_EQ(hand.source.statistics().droppedPatches, 0U);
	rig.coupling.remove(hand.source);
	return forces;
}

struct Difference
{
	double atRest = 0, sliding = 0;  ///< largest difference over the force of one-thread mode
	double force = 0;                ///< at rest [N]
};

Difference compare(const Forces& oracle, const Forces& forces)
{
	Difference d;
	int compared = 0;  // number of ticks of the slide
	d.force = norm(oracle[kRestTicks - 1]);
	for (int i = kRestTicks - 100; i < kRestTicks; ++i)
		d.atRest = std::max(d.atRest, distance(oracle[std::size_t(i)], forces[std::size_t(i)]) / norm(oracle[std::size_t(i)]));
	for (int i = kRestTicks + 20; i < kTicks; ++i)
	{
		const double force = norm(oracle[std::size_t(i)]);
		if (!(force > 0.3 * d.force)) continue;
		++compared;
		d.sliding = std::max(d.sliding, distance(oracle[std::size_t(i)], forces[std::size_t(i)]) / force);
	}
	EXPECT_GT(compared, 30);
	return d;
}
}  // namespace

TEST(DecoupledShapes, AShapeThatStandsFeelsAsInOneThread)
{
	for (const bool compoundTool : {false, true})
		for (const char* name : kShapes)
		{
			if (compoundTool && std::string(name) == "sphere") continue;  // two balls on a ball have no place to rest
			const Shape s = shapeOf(name);
			Case c;
			c.compoundTool = compoundTool;
			const Difference d = compare(inOneThread(s, c), decoupled(s, c));
			std::printf("%s, %s: %.2f N, at rest within %.2f %%, sliding within %.2f %%\n", name, compoundTool ? "two balls" : "a ball",
				d.force, 100 * d.atRest, 100 * d.sliding);
			EXPECT_GT(d.force, 0.5) << name;
			EXPECT_LT(d.atRest, 0.02) << name;
			EXPECT_LT(d.sliding, 0.1) << name;
		}
}

TEST(DecoupledShapes, AShapeOnATableFeelsAsInOneThread)
{
	for (const char* name : {"box", "upright cylinder", "compound of boxes"})
		for (const double rate : {60.0, 240.0})
		{
			const Shape s = shapeOf(name);
			Case c;
			c.mass = 1;
			c.rate = rate;
			const Difference d = compare(inOneThread(s, c), decoupled(s, c));
			std::printf("%s on a table, world at %g Hz: %.2f N, at rest within %.2f %%, sliding within %.2f %%\n", name, rate, d.force,
				100 * d.atRest, 100 * d.sliding);
			EXPECT_GT(d.force, 0.5) << name;
			EXPECT_LT(d.atRest, 0.02) << name << rate;
			EXPECT_LT(d.sliding, 0.1) << name << rate;
		}
}

// With nothing set, the stiffness follows what presses. Otherwise the ball sinks into a box by up to 4 mm.
TEST(DecoupledShapes, WithNothingSetAShapeFeelsAsInOneThread)
{
	for (const double mass : {0.0, 1.0})
		for (const char* name : {"box", "sphere", "capsule", "cylinder", "compound"})
		{
			if (mass > 0 && std::string(name) != "box") continue;
			const Shape s = shapeOf(name);
			Case c;
			c.mass = mass;
			c.stiffness = 0;
			c.dissipation = -1;
			const Difference d = compare(inOneThread(s, c), decoupled(s, c));
			std::printf("%s with nothing set, %s: %.2f N, at rest within %.2f %%, sliding within %.2f %%\n", name,
				mass > 0 ? "on a table" : "fixed", d.force, 100 * d.atRest, 100 * d.sliding);
			EXPECT_GT(d.force, 0.5) << name;
			EXPECT_LT(d.atRest, 0.02) << name;
			EXPECT_LT(d.sliding, 0.1) << name;
		}
}

// The tool's parts have no trees, so the tree of the body finds the force. A compound of a tool is two closed forms.
TEST(DecoupledShapes, AToolInClosedFormFeelsABodyWithATreeAsInOneThread)
{
	for (const bool compoundTool : {false, true})
	{
		const Shape s = shapeOf("box");
		Case c;
		c.compoundTool = compoundTool;
		c.treeOfTool = false;
		const Difference d = compare(inOneThread(s, c), decoupled(s, c));
		std::printf(
			"tool in closed form: %.2f N, at rest within %.2f %%, sliding within %.2f %%\n", d.force, 100 * d.atRest, 100 * d.sliding);
		EXPECT_GT(d.force, 0.5);
		EXPECT_LT(d.atRest, 0.02);
		EXPECT_LT(d.sliding, 0.1);
	}
}

// The force while the tool sinks in is half as large again as at rest, so it shows which dissipation counts.
TEST(DecoupledShapes, TheDissipationIsThatOfTheMaterials)
{
	const Shape s = shapeOf("box");
	double largest[2] = {};
	for (const double dissipation : {0.0, 60.0})
	{
		Case c;
		c.dissipation = dissipation;
		const Forces oracle = inOneThread(s, c), forces = decoupled(s, c);
		double worst = 0;
		for (std::size_t i = 0; i < forces.size(); ++i)
		{
			worst = std::max(worst, distance(oracle[i], forces[i]));
			if (i < kRestTicks) largest[dissipation > 0] = std::max(largest[dissipation > 0], norm(forces[i]));
		}
		EXPECT_LT(worst, 0.02 * norm(oracle[kRestTicks - 1])) << dissipation;
	}
	EXPECT_GT(std::abs(largest[1] - largest[0]), 0.05 * largest[0]);
}

// All that the hand's coupling gave is in tool and body. It is counted from outside.
TEST(DecoupledShapes, ImpulsesBalanceForEachShapeInEachThreading)
{
	for (const auto threading : {ContactThreading::InHapticThread, ContactThreading::OwnThread, ContactThreading::InWorldThread})
		for (const char* name : kShapes)
			for (const bool compoundTool : {false, true})
			{
				if (compoundTool && threading != ContactThreading::InHapticThread) continue;
				const Shape s = shapeOf(name);
				Tool tool(compoundTool);
				DecoupledRig rig(60);
				const auto tree = std::move(rig.world.attach(&tool.ball, ballTree())).value();
				btRigidBody* body = rig.add(*s.shape, 0.5, {});
				BulletDecoupledSettings settings = handSettings();
				settings.topology = threading;
				rig.hands.push_back(std::make_unique<Hand>(rig.world, tool.shape(), rig.clock, startAbove(s), settings));
				Hand& hand = *rig.hands.back();
				rig.coupling.add(hand.source);
				hand.script = [](double t) { return ist::Twist{{t < 0.5 ? 0.01 : 0, t < 0.5 ? -0.06 : 0, 0}, {}}; };
				rig.run(0.8);
				rig.stepWorld();
				const Vec3 balance = hand.momentum() + 0.5 * vec3(body->getLinearVelocity()) - hand.coupled;
				EXPECT_GT(0.5 * norm(vec3(body->getLinearVelocity())), 0.005) << name;
				EXPECT_LT(norm(balance), 1e-3 * norm(hand.coupled)) << name << ", " << int(threading) << ", " << compoundTool;
				rig.coupling.remove(hand.source);
			}
}

TEST(DecoupledShapes, ATickDoesNotAllocate)
{
	for (const auto threading : {ContactThreading::InHapticThread, ContactThreading::OwnThread, ContactThreading::InWorldThread})
		for (const char* name : kShapes)
		{
			const Shape s = shapeOf(name);
			Tool tool(true);
			DecoupledRig rig(60);
			const auto tree = std::move(rig.world.attach(&tool.ball, ballTree())).value();
			rig.add(*s.shape, 0, {});
			BulletDecoupledSettings settings = handSettings();
			settings.topology = threading;
			rig.hands.push_back(std::make_unique<Hand>(rig.world, tool.shape(), rig.clock, startAbove(s), settings));
			Hand& hand = *rig.hands.back();
			rig.coupling.add(hand.source);
			rig.coupling.show(rig.period);
			long inTicks = 0;
			bool touched = false;
			for (int i = 0; i < 400; ++i)
			{
				if (i % 16 == 0) rig.stepWorld();
				rig.clock.sleepUntil((i + 1) * kTickPeriod);
				const long before = allocationCount();
				hand.script = {};
				hand.state.X_WH.translation.y -= 1e-5;
				hand.tick(0);
				hand.source.serveContacts();
				inTicks += allocationCount() - before;
				touched = touched || hand.step.contactCount > 0;
			}
			EXPECT_TRUE(touched) << name;
			EXPECT_EQ(inTicks, 0) << name << ", " << int(threading);
			rig.coupling.remove(hand.source);
		}
}

namespace
{
/// Level ground of 0.4 m x 0.4 m whose surface is at y = 0: a heightfield, and a triangle mesh.
struct LevelGround
{
	std::vector<float> heights = std::vector<float>(25, 0.0f);
	btHeightfieldTerrainShape field{5, 5, heights.data(), btScalar(0), btScalar(0), 1, false};
	btTriangleMesh triangles;
	std::unique_ptr<btBvhTriangleMeshShape> mesh;
	LevelGround()
	{
		field.setLocalScaling(btVector3(btScalar(0.1), 1, btScalar(0.1)));
		const btVector3 corners[] = {bullet({-0.2, 0, -0.2}), bullet({-0.2, 0, 0.2}), bullet({0.2, 0, 0.2}), bullet({0.2, 0, -0.2})};
		triangles.addTriangle(corners[0], corners[1], corners[2]);
		triangles.addTriangle(corners[0], corners[2], corners[3]);
		mesh = std::make_unique<btBvhTriangleMeshShape>(&triangles, true);
	}
};

/// The force that a hand feels whose ball is pressed 3 mm deep into a static body, at rest [N].
Vec3 forceOnBall(DecoupledRig& rig, btCollisionShape& shape)
{
	rig.add(shape, 0, {});
	Hand& hand = rig.addHand({0.013, kBallRadius + 0.002, 0.021});
	hand.script = pressAndSlide;
	rig.run(1.2);
	return -hand.step.coupling.force;
}
}  // namespace

// Without a tree a heightfield or a triangle mesh is not felt. With that of a tree source it feels as a half-space does.
TEST(DecoupledShapes, GroundIsFeltByItsTree)
{
	LevelGround ground;
	for (btCollisionShape* shape : {static_cast<btCollisionShape*>(&ground.field), static_cast<btCollisionShape*>(ground.mesh.get())})
	{
		DecoupledRig without(60);
		btRigidBody* body = without.add(*shape, 0, {});
		without.addHand({0.013, kBallRadius + 0.002, 0.021});
		without.run(0.1);
		ASSERT_TRUE(findUnfelt(without.coupling, body)) << shape->getName();
		EXPECT_EQ(findUnfelt(without.coupling, body)->reason, BulletUnfeltBody::NoModel);

		DecoupledRig with(60), plane(60);
		btISTTreeSettings settings;
		settings.build.maxSpheres = 300;
		settings.cacheFolder = TREE_FOLDER;
		btISTTreeSource trees(with.world.registration().registry(), settings);
		const btISTPendingAttachment tree = trees.attachGround(shape);
		trees.finish();
		ASSERT_TRUE(tree.isAttached()) << tree.error();
		const Vec3 felt = forceOnBall(with, *shape), expected = forceOnBall(plane, plane.planeShape);
		EXPECT_TRUE(with.coupling.unfelt().empty()) << with.coupling.unfeltReport({});
		EXPECT_GT(expected.y, 1);
		EXPECT_NEAR(felt.y, expected.y, 0.05 * expected.y) << shape->getName();
		EXPECT_LT(std::hypot(felt.x, felt.z), 0.02 * expected.y);
	}
}

TEST(DecoupledShapes, AHandThatIsAddedTwiceIsOneHand)
{
	DecoupledRig rig(60);
	btRigidBody* box = rig.addBox(0.3, {0.0405, 0, 0});
	Hand& hand = rig.addHand({});
	rig.coupling.add(hand.source);
	hand.script = [](double t) { return ist::Twist{{t > 0.1 ? std::min(0.4, t - 0.1) : 0, 0, 0}, {}}; };
	rig.run(0.6);
	rig.stepWorld();
	const Vec3 given = -hand.source.receivedImpulse();
	EXPECT_GT(given.x, 0.05);
	EXPECT_LT(norm(0.3 * vec3(box->getLinearVelocity()) - given), 1e-5);
	rig.coupling.remove(hand.source);
	rig.run(0.1);
	EXPECT_EQ(hand.step.contactCount, 0);
}

#if defined(__GLIBC__)
namespace
{
long pageFaults()
{
	rusage usage{};
	getrusage(RUSAGE_THREAD, &usage);
	return usage.ru_minflt;
}
}  // namespace

// The first query of a hand against a curved closed form. Another workspace has asked before, so that code and trees are resident.
TEST(DecoupledShapes, TheFirstTouchOfACurvedShapeCausesNoPageFaults)
{
	mallopt(M_MMAP_THRESHOLD, 1 << 20);  // large blocks are new pages, and none of an earlier test
	const std::vector<ToolPart> tool{toolPartOf(ballTree())};
	MirroredPair pair;
	pair.field = ist::SphereField(0.03);
	pair.k = 1e7;
	const MirroredBody body;
	std::vector<LinearContact> found(8);
	BulletToolContacts earlier(tool), finder(tool);
	double volume = 0;
	const ist::Pose X_WT{{}, {0, 0.02, 0}};
	ASSERT_GT(earlier.find(X_WT, pair, body, {}, found.data(), int(found.size()), volume), 0);
	const long before = pageFaults();
	ASSERT_GT(finder.find(X_WT, pair, body, {}, found.data(), int(found.size()), volume), 0);
	const long faults = pageFaults() - before;
	const int pairs = found[0].pairs;
	std::printf("%d terms, %ld page faults\n", pairs, faults);
	EXPECT_GT(pairs, 100);
	EXPECT_EQ(faults, 0);
}
#endif
