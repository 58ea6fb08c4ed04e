// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"

#include "BulletHapticForce/Law/btContactLaw.h"

#include <numbers>
#include <string>

using namespace scenario;
using ist::Vec3;

namespace
{
constexpr double kGravity = 9.81;

Solid box(const Vec3& size, int64_t spheres) { return Solid(ist::makeBoxMesh(0.5 * size), spheres); }

/// Adds a slab with its top at y = 0. It has so few spheres that its mean gap is much larger than the allowed sinkage of the bodies on
/// it.
btRigidBody* addSlab(Scene& scene, const Vec3& size)
{
	static std::vector<std::pair<Vec3, Solid>> known;
	auto found = std::find_if(known.begin(), known.end(), [&](const auto& slab) { return norm(slab.first - size) == 0; });
	if (found == known.end()) found = known.insert(known.end(), {size, box(size, 1000)});
	return scene.add(scene.volumetricShape(found->second), 0, 0, at({0, -size.y / 2, 0}));
}

/// The lowest contact of `body` that touches.
const btISTContact* contactBelow(Scene& scene, const btRigidBody* body)
{
	const btISTContact* lowest = nullptr;
	for (const btISTContact* contact : scene.world.contacts().contacts())
	{
		if ((contact->bodyA != body && contact->bodyB != body) || contact->patchCount == 0) continue;
		const auto place = [](const btISTContact* c) { return (c->X_WA * (c->treeA->origin + c->total.firstMoment / c->total.volume)).y; };
		if (!lowest || place(contact) < place(lowest)) lowest = contact;
	}
	return lowest;
}

std::vector<btRigidBody*> addTower(Scene& scene, const Solid& cube, double edge, double mass, int count)
{
	std::vector<btRigidBody*> cubes;
	for (int i = 0; i < count; ++i)
		cubes.push_back(scene.add(scene.volumetricShape(cube), mass, mass * edge * edge / 6, at({0, (.5 + i) * edge, 0})));
	return cubes;
}

/// A table top of 1 m by 0.6 m on four legs of 40 mm by 40 mm, with its feet at y = 0.
ist::Mesh tableMesh()
{
	ist::Mesh table = ist::translated(ist::makeBoxMesh({.5, .015, .3}), {0, .735, 0});
	for (int i = 0; i < 4; ++i)
	{
		const ist::Mesh leg = ist::translated(ist::makeBoxMesh({.02, .3625, .02}), {i & 1 ? .45 : -.45, .3625, i & 2 ? .25 : -.25});
		const uint32_t first = uint32_t(table.vertices.size());
		table.vertices.insert(table.vertices.end(), leg.vertices.begin(), leg.vertices.end());
		for (const auto& t : leg.triangles) table.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
	}
	return table;
}
}  // namespace

// The depth must not be bounded by the gap of the ground: a crate of 0.3 m would fall through closed slabs of 10 m and more.
TEST(DefaultStiffness, ACrateRestsOnClosedSlabsOfAnySize)
{
	const Solid crate = box({.3, .3, .3}, 1000);
	for (const double side : {1., 10., 50.})
		for (const double rate : {60., 240.})
		{
			Scene scene;
			addSlab(scene, {side, .2, side});
			btRigidBody* body = scene.add(scene.volumetricShape(crate), 20, .3, at({.04, .151, -.03}));
			scene.run(3, rate);
			const std::string where = "side " + std::to_string(side) + ", rate " + std::to_string(rate);
			EXPECT_GT(height(body), .15 - .2 * .3) << where;  // the leaves of such ground are larger than the crate
			EXPECT_LT(height(body), .15 + .2 * .3) << where;
			EXPECT_LT(double(body->getLinearVelocity().length()), .01) << where;
		}
}

// There is no bound by the step on Bullet's own shapes, and the area of the ground must not count as that of the contact.
TEST(DefaultStiffness, ABoxOfBulletRestsOnClosedSlabsOfAnySize)
{
	for (const double side : {1., 10., 50.})
	{
		Scene scene;
		addSlab(scene, {side, .2, side});
		btRigidBody* body = scene.add(
			scene.shape<btBoxShape>(btVector3(btScalar(.15), btScalar(.15), btScalar(.15))), 1, .015, at({.04, .151, -.03}));
		scene.run(3, 60);
		EXPECT_NEAR(height(body), .15, .03) << side;
		EXPECT_LT(std::fabs(double(body->getLinearVelocity().y())), .01) << side;
	}
}

// Rod and table press on a tenth of the area that the rule assumes, on ground with gaps of 15 mm.
TEST(DefaultStiffness, ARodOnItsEndRestsOnClosedGround)
{
	const ist::Pose upright{ist::rotationMatrix(ist::quaternionFromRotationVector({-std::numbers::pi / 2, 0, 0})), {}};
	const Solid rod(ist::transformed(ist::makeCylinderMesh(.01, .5), upright), 1000);
	Scene scene;
	addSlab(scene, {2, .5, 2});
	btRigidBody* body = scene.add(scene.volumetricShape(rod), .3, .025, at({0, .5005, 0}));
	body->setAngularFactor(btVector3(0, 0, 0));
	scene.run(3, 60);
	EXPECT_NEAR(height(body), .5, .02);
}

TEST(DefaultStiffness, ATableRestsOnItsLegs)
{
	const Solid table(tableMesh(), 1000);
	double foot = 0;
	for (const Vec3& p : table.mesh.vertices) foot = std::min(foot, p.y);
	for (const bool onTree : {false, true})
	{
		Scene scene;
		if (onTree) addSlab(scene, {4, .5, 4});
		else scene.addFloor();
		btRigidBody* body = scene.add(scene.volumetricShape(table), 15, 1.5, at({0, .002 - foot, 0}));
		scene.run(3, 60);
		EXPECT_NEAR(height(body), -foot, .05) << onTree;
		EXPECT_LT(tilt(body), .07) << onTree;
		EXPECT_LT(double(body->getLinearVelocity().length()), .01) << onTree;
	}
}

TEST(DefaultStiffness, TowersOfThreeAndOfFiveStand)
{
	const Solid cube = box({.2, .2, .2}, 3000);
	for (const int count : {3, 5})
	{
		Scene scene;
		scene.addFloor();
		const btRigidBody* top = addTower(scene, cube, .2, 8, count).back();
		scene.run(10, 60);
		// Each of the lower contacts is twice s (docs/stability.md) deep at the most, because both bodies are soft: 6 mm for five cubes.
		EXPECT_NEAR(height(top), .2 * (count - .5), count == 3 ? .005 : .007) << count;
		EXPECT_LT(std::hypot(double(top->getWorldTransform().getOrigin().x()), double(top->getWorldTransform().getOrigin().z())), .02)
			<< count;
		EXPECT_LT(tilt(top), .03) << count;
	}
}

// The lowest contact carries the whole pile, whatever the order of the bodies. All other contacts are equally stiff.
TEST(DefaultStiffness, CarriesTheWeightOfTheWholePile)
{
	const Solid cube = box({.2, .2, .2}, 300);
	double alone = 0;
	for (const int count : {1, 2, 4})
	{
		Scene scene;
		scene.addFloor();
		const std::vector<btRigidBody*> cubes = addTower(scene, cube, .2, 8, count);
		for (btRigidBody* body : cubes) body->setAngularFactor(btVector3(0, 0, 0));
		scene.run(1, 60);
		const btISTContact* lowest = contactBelow(scene, cubes.front());
		ASSERT_TRUE(lowest);
		EXPECT_NEAR(lowest->constants.load, count * 8 * kGravity, 1e-4 * count * 8 * kGravity);
		EXPECT_EQ(lowest->constants.rule, btISTStiffnessRule::Pressed);
		if (count == 1) alone = lowest->constants.k;
		EXPECT_NEAR(lowest->constants.k, count * alone, .1 * count * alone);
		EXPECT_NEAR(lowest->depth, 3e-4 * .2, .1 * 3e-4 * .2);
		EXPECT_EQ(scene.world.statistics().contactsTooDeep, 0u);
	}
}

// Each link carries all links below it. If only the heaviest link counted, they would pass through each other.
TEST(DefaultStiffness, AChainHangs)
{
	constexpr int kLinks = 20;
	constexpr double kPitch = .159;  // twice the ring's radius minus the tube's diameter, plus a little play
	const Solid ring(ist::makeTorusMesh(.1, .02, 64, 32), 1000);
	for (const int rate : {60, 120, 240})
	{
		Scene scene;
		std::vector<btRigidBody*> links;
		for (int i = 0; i < kLinks; ++i)
			links.push_back(scene.add(
				scene.volumetricShape(ring), i > 0 ? .2 : 0, 1e-3, at({0, -kPitch * i, 0}, {0, i % 2 ? std::numbers::pi / 2 : 0, 0})));
		scene.run(3, rate);
		for (int i = 1; i < kLinks; ++i)
		{
			const double apart = height(links[size_t(i) - 1]) - height(links[size_t(i)]);
			EXPECT_GT(apart, .15) << rate << " Hz, link " << i;
			EXPECT_LT(apart, .18) << rate << " Hz, link " << i;  // 0.24 and more if they had passed
		}
	}
}

TEST(DefaultStiffness, FollowsTheGravityOfWorldAndOfBodies)
{
	const Solid cube = box({20, 20, 20}, 300);  // a world in centimetres
	const btVector3 down(0, btScalar(-981), 0);
	double heights[4], stiffness[4];
	for (int order = 0; order < 4; ++order)
	{
		Scene scene;
		btDiscreteDynamicsWorld& bullet = scene.world.bullet();
		if (order == 0)
		{
			EXPECT_FALSE(scene.world.setGravity(down));
		}
		if (order == 1) bullet.setGravity(down);  // set in Bullet, without btISTWorld
		if (order == 3) bullet.setGravity(btVector3(0, 0, 0));
		scene.addFloor();
		const std::vector<btRigidBody*> cubes = addTower(scene, cube, 20, 8, 2);
		if (order == 2) bullet.setGravity(down);
		if (order == 3)
			for (btRigidBody* body : cubes) body->setGravity(down);
		scene.run(2, 60);
		ASSERT_TRUE(contactBelow(scene, cubes.front()));
		heights[order] = height(cubes.back());
		stiffness[order] = contactBelow(scene, cubes.front())->constants.k;
		EXPECT_NEAR(heights[order], 30, .3) << order;
	}
	for (int order = 1; order < 4; ++order)
	{
		EXPECT_EQ(heights[order], heights[0]) << order;
		EXPECT_EQ(stiffness[order], stiffness[0]) << order;
	}
}

// A body as light as this could not come to rest on a contact that carries the pile. The load that a heavy body presses through a light
// one allows a stiffer contact.
TEST(DefaultStiffness, IsNeverStifferThanTheStepBears)
{
	const Solid cube = box({.2, .2, .2}, 300);
	for (const double rate : {60., 240.})
		for (const bool heavyOnTop : {false, true})
		{
			Scene scene;
			scene.addFloor();
			const double light = .1, heavy = 1e3;
			btRigidBody* lower = scene.add(scene.volumetricShape(cube), heavyOnTop ? light : heavy, 10, at({0, .1, 0}));
			btRigidBody* upper = scene.add(scene.volumetricShape(cube), heavyOnTop ? heavy : light, 10, at({0, .31, 0}));
			for (btRigidBody* body : {lower, upper}) body->setAngularFactor(btVector3(0, 0, 0));
			for (int i = 0; i < 4 * rate; ++i)
			{
				scene.step(1 / rate);
				for (const btISTContact* contact : scene.world.contacts().contacts())
				{
					if (contact->patchCount == 0 || !contact->treeB) continue;
					double area = 0;
					for (int p = 0; p < contact->patchCount; ++p) area += norm(contact->patches[p].areaVector);
					if (!heavyOnTop && i > 1.5 * rate)
					{
						EXPECT_LT(contact->constants.k * area / (rate * rate * light), 1.0001 * kStiffestPerStep);
					}
				}
			}
			EXPECT_NEAR(height(upper), .3, .015) << rate << heavyOnTop;
			// A body that fell deeper in one step than any force had stored turns back and forth at up to half of g h: the energy tank
			// returns no more than it has taken.
			EXPECT_LT(std::fabs(double(upper->getLinearVelocity().y())), .5 * 9.81 / rate) << rate << heavyOnTop;
		}
}

TEST(DefaultStiffness, LeavesAGivenStiffnessAsItIs)
{
	const Solid cube = box({.2, .2, .2}, 300);
	Scene scene;
	scene.addFloor();
	const std::vector<btRigidBody*> cubes = addTower(scene, cube, .2, 8, 3);
	for (const btRigidBody* body : cubes) scene.setStiffness(body, 3e12);
	for (int i = 0; i < 30; ++i)
	{
		scene.step(1. / 60);
		for (const btISTContact* contact : scene.world.contacts().contacts())
		{
			const bool both = contact->treeB != nullptr;
			EXPECT_EQ(contact->constants.k, both ? 1.5e12 : 3e12);
			EXPECT_EQ(contact->constants.rule, btISTStiffnessRule::Given);
		}
	}
}
