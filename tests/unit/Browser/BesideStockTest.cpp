// SPDX-License-Identifier: Zlib
#include "demos/browser/catalog/BesideStock.h"
#include "demos/browser/catalog/DemoRun.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "tests/EachDemo.h"

#include <cmath>

using namespace browser;
using ist::Vec3;

namespace
{
DemoOptions fewSpheres()
{
	DemoOptions options;
	options.cache = TREE_FOLDER;
	options.spheres = 300;
	return options;
}

std::vector<ist::Pose> posesOf(BrowsableDemo& demo)
{
	DrawList list;
	demo.draw({}, list);
	std::vector<ist::Pose> poses;
	for (const DrawnSurface& s : list.surfaces) poses.push_back(s.X_WM);
	return poses;
}

double farthest(const std::vector<ist::Pose>& a, const std::vector<ist::Pose>& b)
{
	double most = a.size() == b.size() ? 0 : 1e300;
	for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) most = std::max(most, distance(a[i].translation, b[i].translation));
	return most;
}
}  // namespace

TEST(BesideStock, HalvesBeginAlikeAndPartLater)
{
	const auto demo = makeDemo(*findDemo("stack"), true);
	ASSERT_FALSE(demo->prepare(fewSpheres()));
	for (Parameter& p : demo->parameters()) *p.value = 0.5 * (p.least + p.most);
	ASSERT_FALSE(demo->restart());
	const auto halves = demo->halves();
	ASSERT_EQ(halves.size(), 2u);
	EXPECT_EQ(halves[0].title, "stock Bullet");
	const auto start = posesOf(*halves[1].demo);
	EXPECT_EQ(start.size(), 6u);
	EXPECT_EQ(farthest(posesOf(*halves[0].demo), start), 0);
	for (int i = 0; i < 60; ++i) demo->step(demo->stepSize());
	EXPECT_GT(farthest(posesOf(*halves[0].demo), posesOf(*halves[1].demo)), 1e-4);
	EXPECT_EQ(halves[0].demo->time(), halves[1].demo->time());
	ASSERT_FALSE(demo->restart());
	EXPECT_EQ(farthest(posesOf(*halves[0].demo), posesOf(*halves[1].demo)), 0);
	EXPECT_EQ(farthest(posesOf(*halves[1].demo), start), 0);
}

TEST(BesideStock, FiguresOfStockBulletFollowOursUnjudged)
{
	const auto alone = findDemo("heavy-on-light")->make(), both = findDemo("stock-against-ours")->make();
	ASSERT_FALSE(alone->prepare(fewSpheres()));
	ASSERT_FALSE(both->prepare(fewSpheres()));
	const auto a = runDemo(*alone, "", "", {}), b = runDemo(*both, "", "", {});
	ASSERT_TRUE(a && b);
	ASSERT_EQ(b.value().figures.size(), 2 * a.value().figures.size());
	for (size_t i = 0; i < a.value().figures.size(); ++i)
	{
		const Figure &ours = b.value().figures[i], &stock = b.value().figures[a.value().figures.size() + i];
		EXPECT_EQ(ours.value, a.value().figures[i].value) << "the other half must not be felt";
		EXPECT_EQ(ours.expected, a.value().figures[i].expected);
		EXPECT_EQ(stock.name, ours.name + " in stock Bullet");
		EXPECT_FALSE(stock.judged());
	}
}

TEST(BesideStock, HandTakesTheBodyOfItsHalfAlone)
{
	const auto demo = findDemo("stock-against-ours")->make();
	ASSERT_FALSE(demo->prepare(fewSpheres()));
	for (const size_t taken : {0u, 1u})
	{
		ASSERT_FALSE(demo->restart());
		const auto halves = demo->halves();
		ASSERT_TRUE(halves[taken].demo->grab({0, 1.5, 10}, {0, 0, -1}));
		demo->drag({0, 1, 0}, {});
		for (int i = 0; i < 30; ++i) demo->step(demo->stepSize());
		EXPECT_GT(posesOf(*halves[taken].demo)[1].translation.y, 2) << taken;
		EXPECT_LT(posesOf(*halves[1 - taken].demo)[1].translation.y, 1.51) << taken;
		demo->release();
	}
	// A device leads both.
	ASSERT_FALSE(demo->restart());
	ASSERT_TRUE(demo->grabTool());
	demo->drag({0, 1, 0}, {});
	for (int i = 0; i < 30; ++i) demo->step(demo->stepSize());
	for (const auto& half : demo->halves()) EXPECT_GT(posesOf(*half.demo)[1].translation.y, 2) << half.title;
}

// Newton: what rests is carried. Bullet's own impulses are added up with their signs, friction among them.
TEST(StockContacts, CarryAWeightOnASlope)
{
	for (const bool swapped : {false, true})
	{
		const Vec3 up = normalized(Vec3{0.2, 1, 0.1});
		DemoWorld world(scenes::Response::Stock);
		if (!swapped) world.addPlane(up, 0, 1);
		SolidPtr solid;
		ASSERT_FALSE(makeSolid(solid, "box", ist::makeBoxMesh({0.2, 0.1, 0.15}), 100, fewSpheres()));
		BodySetup setup;
		setup.mass = 3;
		setup.friction = 1;
		setup.X_WM.rotation = ist::rotationMatrix(ist::quaternionFromRotationVector(cross(Vec3{0, 1, 0}, up)));
		setup.X_WM.translation = 0.1 * up;
		btRigidBody* box = world.add(solid, std::move(setup));
		if (swapped) world.addPlane(up, 0, 1);
		for (int i = 0; i < 240; ++i) world.step(1.0 / 240);
		const Vec3 force = world.contactForce(box);
		EXPECT_NEAR(force.y, 3 * 9.81, 0.02 * 3 * 9.81);
		EXPECT_NEAR(std::hypot(force.x, force.z), 0, 0.05 * 3 * 9.81);
		EXPECT_NEAR(world.contactSums().force, 3 * 9.81, 0.05 * 3 * 9.81);
	}
}

TEST(StockShape, IsWhatBulletHasForTheMesh)
{
	EXPECT_EQ(makeStockShape(ist::makeBoxMesh({1, 2, 3}), false).shape->getShapeType(), CONVEX_HULL_SHAPE_PROXYTYPE);
	EXPECT_EQ(makeStockShape(ist::makeSphereMesh(1, 2), true).shape->getShapeType(), CONVEX_HULL_SHAPE_PROXYTYPE);
	EXPECT_EQ(makeStockShape(ist::makeTorusMesh(1, 0.3), false).shape->getShapeType(), GIMPACT_SHAPE_PROXYTYPE);
	EXPECT_EQ(makeStockShape(ist::makeTorusMesh(1, 0.3), true).shape->getShapeType(), TRIANGLE_MESH_SHAPE_PROXYTYPE);
	ist::Mesh dented = ist::makeBoxMesh({1, 1, 1});
	EXPECT_TRUE(isConvex(dented));
	dented.vertices[0] = 0.2 * dented.vertices[0];
	EXPECT_FALSE(isConvex(dented));
}

/// Every scene that Bullet's own contact has an answer to.
class StockSide : public testing::TestWithParam<DemoEntry>
{};
TEST_P(StockSide, StepsAndShowsItself)
{
	const auto demo = makeDemo(GetParam(), true);
	if (!GetParam().make()->hasStockSide())
	{
		EXPECT_EQ(demo->halves().empty(), std::string(GetParam().name) != "stock-against-ours");
		return;
	}
	ASSERT_FALSE(demo->prepare(fewSpheres()));
	ASSERT_FALSE(demo->restart());
	ASSERT_EQ(demo->halves().size(), 2u);
	for (int i = 0; i < 12; ++i) demo->step(demo->stepSize());
	const auto poses = posesOf(*demo->halves()[0].demo);
	EXPECT_EQ(poses.size(), posesOf(*demo->halves()[1].demo).size());
	for (const ist::Pose& X : poses) EXPECT_TRUE(ist::isRigid(X, 1e-3));
	for (const Figure& f : demo->figures()) EXPECT_TRUE(std::isfinite(f.value)) << f.name;
	EXPECT_FALSE(demo->report().empty());
}
INSTANTIATE_TEST_SUITE_P(Demos, StockSide, testing::ValuesIn(demoCatalog()), testNameOf);
