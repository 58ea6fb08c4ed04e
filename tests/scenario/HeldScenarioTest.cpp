// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"

#include <numbers>
#include <tuple>

using namespace scenario;
using ist::Vec3;

// Bodies that stop each other within one step: neither one's own motion foretells it. The oracles are energy, and links that stay in each
// other.
namespace
{
constexpr double kGravity = 9.81, kRing = 0.05, kLinkTube = 0.012, kFlatTube = 0.02, kLinkMass = 0.05, kHolderMass = 50;

const Solid& link()
{
	static const Solid solid(ist::makeTorusMesh(kRing, kLinkTube, 48, 24), 300);
	return solid;
}

/// A thicker ring, for stacks; its axis is z.
const Solid& flatRing()
{
	static const Solid solid(ist::makeTorusMesh(kRing, kFlatTube, 48, 24), 300);
	return solid;
}

/// Kinetic energy and that of the weight [J]; in a frame that moves at `frame` [m/s].
double energy(const btRigidBody& body, const Vec3& frame = {})
{
	const Vec3 v = vec(body.getLinearVelocity()) - frame;
	const btVector3 w = body.getWorldTransform().getBasis().transpose() * body.getAngularVelocity(), i = body.getLocalInertia();
	return 0.5 * (dot(v, v) * body.getMass() + double((w * w).dot(i))) + body.getMass() * kGravity * height(&body);
}

/// A chain of rings that leans, hangs by its first one, and begins without weight on it.
struct Chain : Scene
{
	std::vector<btRigidBody*> links;
	Vec3 frame;

	/// Neighbours are `share` of the full pitch apart. With a speed along z [m/s], the first link is no fixed but a heavy body.
	Chain(int count, double share, double lean, double speed) : frame{0, 0, speed}
	{
		world.setGravity(btVector3(0, btScalar(-kGravity), 0));
		btCollisionShape* shape = volumetricShape(link());
		const double inertia = kLinkMass * (kRing * kRing + 0.75 * kLinkTube * kLinkTube);
		const btQuaternion leans(btVector3(0, 0, 1), btScalar(lean));
		for (int i = 0; i < count; ++i)
		{
			const btQuaternion turn(btVector3(0, 1, 0), btScalar(i % 2 * std::numbers::pi / 2));
			const btVector3 down(0, btScalar(-share * i * 2 * (kRing - kLinkTube)), 0);
			const double mass = i > 0 ? kLinkMass : speed == 0 ? 0 : kHolderMass;
			links.push_back(add(shape, mass, mass / kLinkMass * inertia, btTransform(leans * turn, quatRotate(leans, down))));
			links.back()->setLinearVelocity(vec(frame));
		}
		links[0]->setGravity(btVector3(0, 0, 0));
	}
	double energyOfAll() const
	{
		double sum = 0;
		for (size_t i = 1; i < links.size(); ++i) sum += energy(*links[i], frame);
		return sum;
	}
	/// Largest distance between the centres of neighbours, less that of taut links [m].
	double stretch() const
	{
		double most = -1;
		for (size_t i = 1; i < links.size(); ++i)
			most = std::max(most,
				double((links[i]->getWorldTransform().getOrigin() - links[i - 1]->getWorldTransform().getOrigin()).length()) -
					2 * (kRing - kLinkTube));
		return most;
	}
};
}  // namespace

// Each link that is caught stops the next one in the same step. From 86 degrees the chain cracks like a whip.
TEST(Held, AChainThatFallsTautHolds)
{
	for (const auto& [rate, k, share, speed, lean] : {std::tuple{60., 0., .98, 0., .6}, {60., 0., 1., 0., .6}, {240., 0., .98, 0., .6},
			 {60., 1e9, .98, 0., .6}, {240., 1e9, .98, 0., .6}, {60., 0., .98, 8., .6}, {60., 0., .98, 0., 1.2}, {60., 0., .98, 0., 1.5}})
	{
		SCOPED_TRACE(testing::Message() << rate << " Hz, k " << k << ", pitch " << share << ", " << speed << " m/s, lean " << lean);
		Chain chain(20, share, lean, speed);
		for (btRigidBody* body : chain.links) chain.setStiffness(body, k);
		double stretch = 0;
		for (int i = 0; i < int(1.5 * rate); ++i)
		{
			chain.step(1 / rate);
			stretch = std::max(stretch, chain.stretch());
		}
		EXPECT_LT(stretch, kLinkTube) << "one link is in another by more than half";
	}
}

// The contacts of a chain are solved together, and what one of them returns must not exceed what all hold. These gained six times the
// energy of their fall.
TEST(Held, AStiffChainGainsNoEnergy)
{
	for (const double k : {1e7, 1e9})
		for (const double rate : {60., 120., 180.})
		{
			SCOPED_TRACE(testing::Message() << rate << " Hz, k " << k);
			Chain chain(20, .98, .6, 0);
			for (btRigidBody* body : chain.links) chain.setStiffness(body, k);
			const double atFirst = chain.energyOfAll();
			for (int i = 0; i < int(rate); ++i)
			{
				chain.step(1 / rate);
				ASSERT_LT(chain.energyOfAll(), atFirst + kLinkMass * kGravity * kLinkTube) << i;
			}
		}
}

// Rings on each other have no way left when the lowest one is stopped.
TEST(Held, AStackThatFallsComesToRest)
{
	static const Solid slab(ist::makeBoxMesh({.5, .1, .5}), 200);
	for (const bool onSlab : {false, true})
		for (const double drop : {1e-4, 2.})
		{
			SCOPED_TRACE(testing::Message() << "from " << drop << " m " << (onSlab ? "on a slab" : "on a plane"));
			Scene scene;
			scene.world.setGravity(btVector3(0, btScalar(-kGravity), 0));
			if (onSlab) scene.add(scene.volumetricShape(slab), 0, 0, at({0, -.1, 0}));
			else scene.addFloor();
			std::vector<btRigidBody*> rings;
			btCollisionShape* shape = scene.volumetricShape(flatRing());
			for (int i = 0; i < 6; ++i)
				rings.push_back(scene.add(
					shape, .2, .2 * kRing * kRing, at({0, drop + kFlatTube + 2.01 * kFlatTube * i, 0}, {std::numbers::pi / 2, 0, 0})));
			double before = 0;
			for (const btRigidBody* ring : rings) before += energy(*ring);
			for (int i = 0; i < 150; ++i)
			{
				scene.step(1. / 60);
				double now = 0;
				for (const btRigidBody* ring : rings) now += energy(*ring);
				ASSERT_LT(now, before + 1e-3) << i;
			}
			for (int i = 0; i < 6; ++i)
			{
				EXPECT_NEAR(height(rings[size_t(i)]), kFlatTube + 2 * kFlatTube * i, .2 * kFlatTube) << i;
				EXPECT_LT(double(rings[size_t(i)]->getLinearVelocity().length()), 1e-3) << i;
			}
		}
}

// What nothing holds is not stopped: bodies that fly side by side, alone or over a floor, keep their motion.
TEST(Held, NeighboursThatNothingStopsFlyOn)
{
	for (const bool floor : {false, true})
	{
		Scene scene;
		scene.world.setGravity(btVector3(0, 0, 0));
		if (floor) scene.addFloor();
		btCollisionShape* shape = scene.volumetricShape(flatRing());
		std::vector<btRigidBody*> rings;
		for (int i = 0; i < 3; ++i)
		{
			rings.push_back(scene.add(
				shape, .2, .2 * kRing * kRing, at({0, 1.01 * kFlatTube + 2.01 * kFlatTube * i, 0}, {std::numbers::pi / 2, 0, 0})));
			rings.back()->setLinearVelocity(btVector3(3, btScalar(floor ? 0.5 : -4), 1));
		}
		for (int i = 0; i < 60; ++i) scene.step(1. / 60);
		for (const btRigidBody* ring : rings) EXPECT_LT(norm(vec(ring->getLinearVelocity()) - Vec3{3, floor ? 0.5 : -4, 1}), 1e-5) << floor;
	}
}

// The contact of a pair that the filter leaves to Bullet is never asked, and has no bodies.
TEST(Held, PairsOfBulletsMayBeginInTheFirstStep)
{
	Scene scene;
	scene.world.setGravity(btVector3(0, 0, 0));
	btCollisionShape* shape = scene.volumetricShape(cube());
	std::vector<btRigidBody*> row;
	for (int i = 0; i < 5; ++i) row.push_back(scene.add(shape, 1, 0.2, at({1.02 * i, 0, 0})));
	scene.world.pairFilter().addPair(row[1], row[2]);
	scene.world.pairFilter().addPair(row[3], row[4]);
	scene.run(0.1, 60);
	for (const btRigidBody* body : row) EXPECT_LT(double(body->getLinearVelocity().length()), 1e-6);
}

// Two light cubes pull away from each other, and heavy ones press them together: their contact bears the difference. By themselves they
// would part in every step, and a contact that is judged by that alone gives all its energy away. Equilibrium is the oracle.
TEST(Held, WhatPartsByItselfIsPressedTogetherByOthers)
{
	constexpr double kPress = 20, kPull = 10, kStiffness = 1e6, kMass[4] = {10, 0.05, 0.05, 10};
	for (const double rate : {60.0, 240.0})
	{
		Scene scene;
		scene.world.setGravity(btVector3(0, 0, 0));
		btCollisionShape* shape = scene.volumetricShape(cube());
		std::vector<btRigidBody*> row;
		for (int i = 0; i < 4; ++i)
		{
			row.push_back(scene.add(shape, kMass[i], kMass[i] / 6, at({1.001 * i, 0, 0})));
			scene.setStiffness(row.back(), kStiffness);
		}
		for (int i = 0; i < int(3 * rate); ++i)
		{
			for (int side = 0; side < 2; ++side)
			{
				const double inward = side == 0 ? 1 : -1;
				row[side == 0 ? 0 : 3]->applyCentralForce(vec(Vec3{inward * kPress, 0, 0}));
				row[side == 0 ? 1 : 2]->applyCentralForce(vec(Vec3{-inward * kPull, 0, 0}));
			}
			scene.step(1 / rate);
		}
		const double depth = 1 - (vec(row[2]->getWorldTransform().getOrigin()) - vec(row[1]->getWorldTransform().getOrigin())).x;
		const double aimed = (kPress - kPull) / (0.5 * kStiffness);
		EXPECT_NEAR(depth, aimed, 0.02 * aimed + (kDouble ? 0 : 1e-6)) << rate;
		EXPECT_LT(double(row[1]->getLinearVelocity().length()), 1e-4) << rate;
	}
}
