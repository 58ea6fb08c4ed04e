// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"
#include "tests/unit/BoredMesh.h"
#include "tests/unit/NotchedBeam.h"

#include <map>
#include <numbers>
#include <string>

using namespace scenario;
using ist::Vec3;

// Scenes in which nothing is set: what a user gets first. The oracles are statics and free fall.
namespace
{
constexpr double kGravity = 9.81;

const Solid& slab()
{
	static const Solid solid(ist::makeBoxMesh({1, .25, 1}), 400);
	return solid;
}

btRigidBody* addSlab(Scene& scene) { return scene.add(scene.volumetricShape(slab()), 0, 0, at({0, -.25, 0})); }

ist::Mesh upright(const ist::Mesh& alongZ)
{
	return ist::transformed(alongZ, {ist::rotationMatrix(ist::quaternionFromRotationVector({-std::numbers::pi / 2, 0, 0})), {}});
}

/// A cone that stands on its tip.
ist::Mesh coneOnTip()
{
	const ist::Quaternion turn = ist::quaternionFromRotationVector({std::numbers::pi / 2, 0, 0});
	return ist::transformed(ist::makeConeMesh(.1, .2), {ist::rotationMatrix(turn), {}});
}

/// Normal force of the contact of the two bodies in the last step, as a vector on `body` [N].
Vec3 forceOn(Scene& scene, const btRigidBody* body, double h) { return 1 / h * impulseOn(scene.world.contacts(), body); }

/// Sum of the magnitudes of the normal forces on the body in the last step [N].
double normalForceOn(Scene& scene, const btRigidBody* body, double h)
{
	double sum = 0;
	for (const btISTContact* contact : scene.world.contacts().contacts())
		if (contact->bodyA == body || contact->bodyB == body) sum += contact->normalImpulse / h;
	return sum;
}
}  // namespace

// Whatever the area that presses: the thickness is the length of the normal line inside of the body.
TEST(DefaultContact, ABodyAtRestLiesShallow)
{
	struct Case
	{
		const char* name;
		Solid solid;
		double mass, thickness, size;
	};
	const Case cases[] = {{"cube", {ist::makeBoxMesh({.05, .05, .05}), 400}, 1, .1, .1},
		{"ball", {ist::makeSphereMesh(.1, 4), 400}, 4, .2, .16},
		{"rod on its end", {upright(ist::makeCylinderMesh(.01, .5, 48)), 400}, .3, 1, .068},
		{"plate on its edge", {ist::makeBoxMesh({.5, .5, .01}), 400}, 15, 1, .27}, {"cone on its tip", {coneOnTip(), 400}, 1, .2, .128}};
	for (const Case& c : cases)
		for (const double rate : {60., 240.})
		{
			Scene scene;
			addSlab(scene);
			const double lowest = -lowestPoint(c.solid.mesh, {});
			btRigidBody* body = scene.add(scene.volumetricShape(c.solid), c.mass, .01, at({.03, lowest + 5e-4, -.02}));
			body->setAngularFactor(btVector3(0, 0, 0));  // guided, because some of them would fall over
			scene.run(2, rate);
			const std::string where = c.name + std::string(" at ") + std::to_string(rate);
			EXPECT_LT(lowest - height(body), std::max(5e-3 * c.thickness, 2e-3 * c.size)) << where;
			EXPECT_GT(lowest - height(body), -2e-3 * c.size) << where;
			EXPECT_LT(double(body->getLinearVelocity().length()), 2e-4) << where;
			EXPECT_NEAR(forceOn(scene, body, 1 / rate).y, c.mass * kGravity, .01 * c.mass * kGravity) << where;
			EXPECT_EQ(scene.world.statistics().contactsTooDeep, 0u) << where;
		}
}

TEST(DefaultContact, ABeamGoesIntoANotchThatIsAsWideOrWiderAndRests)
{
	const Solid beam(ist::makeBoxMesh({.02, .06, .25}), 400);
	for (const double notch : {.04, .042, .046})
	{
		const Solid lower(notchedBeamMesh(notch), 400);
		const double bottom = -ist::massProperties(notchedBeamMesh(notch)).centerOfMass.y;  // of the notch, in the frame of the body
		for (const double rate : {24., 60., 240.})
		{
			if (notch == .04 && rate == 24) continue;  // it lands on an edge and falls off
			Scene scene;
			scene.add(scene.volumetricShape(lower), 0, 0, at({0, -bottom, 0}));
			btRigidBody* body = scene.add(scene.volumetricShape(beam), 1.2, .03, at({0, .06 + .06 + .01, 0}));
			scene.run(2, rate);
			// Without any play it may also rest on top.
			const double expected = notch == .04 && height(body) > .09 ? .12 : .06;
			EXPECT_NEAR(height(body), expected, 5e-4) << notch << " at " << rate;
			EXPECT_LT(double(body->getLinearVelocity().length()), 1e-4) << notch << " at " << rate;
		}
	}
}

// A body stops where it touches, in Bullet's own stepSimulation, and no energy comes from it. The last step is a frame of 0.3 s. A game
// that sets Bullet's flags for continuous collision detection gets the same.
TEST(DefaultContact, NothingFastPassesSomethingThin)
{
	const Solid door(ist::makeBoxMesh({.02, 1, .5}), 400), ball(ist::makeSphereMesh(.03, 3), 300);
	const double thinner = .02;  // of the ball, twice its volume over its surface
	for (const double speed : {5., 20.})
		for (int phase = 0; phase < 20; ++phase)
			for (const bool spike : {false, true})
			{
				Scene scene;
				scene.world.setGravity(btVector3(0, 0, 0));
				scene.add(scene.volumetricShape(door), 0, 0, at({0, 0, 0}));
				btRigidBody* body = scene.add(scene.volumetricShape(ball), .4, 1.4e-4, at({-1 - phase / 2 * speed / 600, .2, .1}));
				body->setLinearVelocity(btVector3(btScalar(speed), 0, 0));
				if (phase % 2)
				{
					body->setCcdMotionThreshold(.015f);
					body->setCcdSweptSphereRadius(.03f);
				}
				double farthest = -1;
				for (int i = 0; i < 60; ++i)
				{
					const bool long_ = spike && i == int(60 / speed) - 1;
					scene.step(long_ ? .3 : 1. / 60);
					farthest = std::max(farthest, double(body->getWorldTransform().getOrigin().x()));
					EXPECT_LT(double(body->getLinearVelocity().length()), speed * (1 + 1e-5));
				}
				EXPECT_LT(farthest, -.05 + thinner / 4) << speed << " m/s, phase " << phase << ", " << spike;
				EXPECT_GT(farthest, -.05 - 2e-4) << speed << " m/s, phase " << phase << ", " << spike;
				EXPECT_LT(std::fabs(double(body->getLinearVelocity().x())), .21) << speed << " m/s, phase " << phase << ", " << spike;
			}
}

// A ball on flat ground has no rolling resistance: the pressure stays below its centre. What it loses comes from its facets: with 5,120 and
// with 81,920 triangles, with 1,000 and with 10,000 spheres it keeps 4.995 to 4.999 of 5 m/s (bench_rolling).
TEST(DefaultContact, ABallRollsOnFlatGroundWithoutResistance)
{
	enum Ground
	{
		Plane,
		Box,
		Tree
	};
	constexpr double kMass = 1, kRadius = .5, kInertia = .4 * kMass * kRadius * kRadius, kSpeed = 5;
	const Solid ball(ist::makeSphereMesh(kRadius, 4), 500);  // 5,120 triangles
	const ist::Vec3 half{30, .5, 30};
	const Solid ground(ist::makeBoxMesh(half), 1000);
	for (const auto& [rate, kind] :
		{std::pair(60., Plane), std::pair(240., Plane), std::pair(60., Box), std::pair(60., Tree), std::pair(240., Tree)})
	{
		Scene scene;
		btCollisionShape* below = kind == Tree ? scene.volumetricShape(ground) : scene.shape<btBoxShape>(vec(half));
		btRigidBody* floor = kind == Plane ? scene.addFloor() : scene.add(below, 0, 0, at({0, -half.y, 0}));
		floor->setFriction(btScalar(.7));
		btRigidBody* body = scene.add(scene.volumetricShape(ball), kMass, kInertia, at({0, kRadius, 0}));
		body->setFriction(btScalar(.7));
		scene.run(.5, rate);
		body->setLinearVelocity(btVector3(btScalar(kSpeed), 0, 0));
		body->setAngularVelocity(btVector3(0, 0, btScalar(-kSpeed / kRadius)));
		const auto energy = [&] {
			return .5 * kMass * double(body->getLinearVelocity().length2()) + .5 * kInertia * double(body->getAngularVelocity().length2()) +
				kMass * kGravity * height(body);
		};
		const double given = energy();
		double most = 0;
		for (int i = 0; i < int(3 * rate); ++i)
		{
			scene.step(1 / rate);
			most = std::max(most, energy());
		}
		EXPECT_LT(most, 1.001 * given) << rate << ' ' << kind;
		const double speed = double(body->getLinearVelocity().length());
		EXPECT_GT(speed, .998 * kSpeed) << rate << ' ' << kind;
		EXPECT_NEAR(double(body->getAngularVelocity().length()) * kRadius, speed, .005 * kSpeed)
			<< rate << ' ' << kind << ": it does not slide";
	}
}

// A cylinder and a pipe roll down a slope of 10 degrees by g sin / (1 + I / m r^2), on a floor with a tree as on a plane.
TEST(DefaultContact, ACylinderAndAPipeRollDownASlope)
{
	constexpr double kRadius = .05, kSlope = 10 * std::numbers::pi / 180, kTime = 1;
	const Solid ground(ist::makeBoxMesh({3, .1, .5}), 500);
	for (const ist::Mesh& mesh : {ist::makeCylinderMesh(kRadius, .05, 512), boredMesh(.045, {kRadius, false}, .05, 512)})
	{
		const Solid roller(mesh, 1000);
		const double inertia = roller.tree->inertia.m[2][2] / roller.tree->volume,
					 exact = kGravity * std::sin(kSlope) / (1 + inertia / (kRadius * kRadius));
		for (const double rate : {240., 1000.})
		{
			Scene scene;
			scene.world.setGravity(btVector3(btScalar(kGravity * std::sin(kSlope)), btScalar(-kGravity * std::cos(kSlope)), 0));
			scene.add(scene.volumetricShape(ground), 0, 0, at({0, -.1, 0}))->setFriction(btScalar(.7));
			btRigidBody* body = scene.add(scene.volumetricShape(roller), 1, inertia, at({-2, kRadius, 0}));
			body->setFriction(btScalar(.7));
			scene.run(kTime, rate);
			EXPECT_NEAR(double(body->getLinearVelocity().x()), exact * kTime, .015 * exact * kTime) << rate << ' ' << roller.tree->volume;
			EXPECT_NEAR(height(body), kRadius, 1e-4);
		}
	}
}

// A first touch is announced with no more than its own depth, and nothing is held before it.
TEST(DefaultContact, WhatDoesNotTouchIsNotHeld)
{
	Scene scene;
	addSlab(scene);
	const Solid cube(ist::makeBoxMesh({.05, .05, .05}), 300);
	btRigidBody* body = scene.add(scene.volumetricShape(cube), 1, .0017, at({0, .05 + .1, 0}));
	double fallen = 0, speed = 0;
	for (int i = 0; i < 60 && fallen + (speed + kGravity / 60) / 60 < .1; ++i)
	{
		scene.step(1. / 60);
		speed += kGravity / 60;
		fallen += speed / 60;
		EXPECT_NEAR(height(body), .15 - fallen, 1e-5) << i;
	}
	EXPECT_GT(fallen, .08);
	scene.step(1. / 60);
	EXPECT_NEAR(height(body), .05, 1e-3) << "it stops at the slab, and not inside of it";
}

// Along an edge of a fit, faces of both directions touch in slivers. Their stiffness must not hold what slides past the edge, and what is
// no contact must not raise it.
TEST(DefaultContact, APinFallsFreelyThroughABoreAndStandsAtItsBottom)
{
	struct Case
	{
		double rate, k;
	};
	const Solid pin(upright(ist::makeCylinderMesh(.01, .03, 128)), 1000);
	for (const double play : {2.5e-4, 1e-5})
	{
		const Solid block(upright(boredMesh(.01 + play, {.03, true}, .02, 128)), 1000);
		for (const auto& [rate, k] : {Case{60, 0}, Case{240, 0}, Case{240, 1e9}})
		{
			Scene scene;
			addSlab(scene);
			scene.add(scene.volumetricShape(block), 0, 0, at({0, .02, 0}))->setFriction(btScalar(.55));
			btRigidBody* body = scene.add(scene.volumetricShape(pin), .15, 5e-5, at({0, .085, 0}));
			body->setFriction(btScalar(.55));
			if (k > 0) scene.setStiffness(body, k);
			double speed = 0, fallen = 0;
			for (; fallen < .035; fallen += speed / rate)
			{
				scene.step(1 / rate);
				speed += kGravity / rate;
			}
			EXPECT_NEAR(height(body), .085 - fallen, .02 * fallen) << play << ' ' << rate << ' ' << k;
			scene.run(.4, rate);
			EXPECT_NEAR(height(body), .03, 1e-4) << play << ' ' << rate << ' ' << k;
			EXPECT_LT(body->getLinearVelocity().length(), 1e-3) << play << ' ' << rate << ' ' << k;
		}
	}
}

// On an elastic foundation a box needs k >= 1.5 F h / (b c^3), with the height h of its centre and its distance c from the edge.
TEST(DefaultContact, AnOverhangOfTwoFifthsStaysAndOneOfMoreThanHalfTips)
{
	const Solid box(ist::makeBoxMesh({.5, .5, .5}), 400), table(ist::makeBoxMesh({1.5, .25, 1.5}), 400);
	for (const double overhang : {.4, .52})
	{
		Scene scene;
		scene.add(scene.volumetricShape(table), 0, 0, at({0, -.25, 0}));
		btRigidBody* body = scene.add(scene.volumetricShape(box), 100, 100. / 6, at({1.5 - .5 + overhang, .5, 0}));
		scene.run(3, 60);
		if (overhang < .5)
		{
			EXPECT_NEAR(height(body), .5, 2e-3);
			EXPECT_LT(tilt(body), 5e-3);
		}
		else
		{
			EXPECT_LT(height(body), 0);
		}
	}
}

// A can slides down a slope of 25 degrees, on which friction moves the pressure to four fifths of its radius. It begins without any
// contact.
TEST(DefaultContact, ACanSlidesDownASlopeUpright)
{
	constexpr double kRadius = .03, kHalfHeight = .06, kFriction = .4, kSlope = 25 * std::numbers::pi / 180;
	const Solid can(upright(ist::makeCylinderMesh(kRadius, kHalfHeight, 96)), 500), ground(ist::makeBoxMesh({2, .1, 1}), 300);
	const double inertia = can.tree->inertia.m[0][0] / can.tree->volume;
	for (const double rate : {60., 240.})
	{
		Scene scene;
		scene.world.setGravity(btVector3(btScalar(kGravity * std::sin(kSlope)), btScalar(-kGravity * std::cos(kSlope)), 0));
		scene.add(scene.volumetricShape(ground), 0, 0, at({0, -.1, 0}))->setFriction(1);
		btRigidBody* body = scene.add(scene.volumetricShape(can), .5, .5 * inertia, at({-1, kHalfHeight, 0}));
		body->setFriction(btScalar(kFriction));
		scene.run(.5, rate);
		const double before = double(body->getLinearVelocity().x());
		EXPECT_LT(tilt(body), .01) << rate;
		scene.run(.5, rate);
		const double exact = kGravity * (std::sin(kSlope) - kFriction * std::cos(kSlope));
		EXPECT_NEAR((double(body->getLinearVelocity().x()) - before) / .5, exact, .01 * exact) << rate;
		EXPECT_LT(tilt(body), .01) << rate;
	}
}

// A ball falls onto a floor from the side, slides on, and meets a wall within the same step. Its free motion passes below the wall.
TEST(DefaultContact, ABodyThatIsDeflectedPassesNothing)
{
	constexpr double r = .03, thickness = .02, most = thickness / 4;
	const Solid ball(ist::makeSphereMesh(r, 3), 400), plate(ist::makeBoxMesh({.5, thickness / 2, .5}), 400);
	std::mt19937_64 random(7);
	std::uniform_real_distribution<double> u(0, 1);
	int deflected = 0;
	for (int i = 0; i < 40; ++i)
	{
		const double speed = 6 + 8 * u(random), h = 1 / 60., drop = .3 * speed * h * u(random),
					 slide = (2.2 * r) + .3 * speed * h * u(random);
		Scene scene;
		scene.world.setGravity(btVector3(0, 0, 0));
		btCollisionShape* shape = scene.volumetricShape(plate);
		scene.add(shape, 0, 0, at({0, -thickness / 2, 0}))->setFriction(0);
		scene.add(shape, 0, 0, at({thickness / 2, .5, 0}, {0, 0, std::numbers::pi / 2}))->setFriction(0);
		btRigidBody* body = scene.add(scene.volumetricShape(ball), .1, .1 * .4 * r * r, at({-r - slide - drop, r + drop, .1 * u(random)}));
		body->setLinearVelocity(vec(Vec3{speed, -speed, 0}));
		for (int step = 0; step < 20; ++step)
		{
			scene.step(h);
			const Vec3 p = vec(body->getWorldTransform().getOrigin());
			EXPECT_LT(p.x, -r + most) << i << ' ' << step;
			EXPECT_GT(p.y, r - most) << i << ' ' << step;
			EXPECT_LT(double(body->getLinearVelocity().length()), std::sqrt(2) * speed * (1 + 1e-5)) << i << ' ' << step;
		}
		deflected += scene.world.statistics().solvedAgain > 0;
	}
	EXPECT_GT(deflected, 20);
}

// Two bodies of random shapes in random poses hit each other, with and without spin. Those with holes and hooks meet several times in a
// step. Before bodies were held where no solve keeps them apart, and turned as far as Bullet turns them, 10 and 5 of 120 such impacts at 5
// m/s with spins were deeper than a quarter and a half.
TEST(DefaultContact, NoImpactOfTwoBodiesIsDeep)
{
	std::vector<Solid> solids;
	for (const ist::Mesh& mesh : {ist::makeBoxMesh({.04, .03, .02}), ist::makeBoxMesh({.08, .006, .02}), ist::makeBoxMesh({.1, .005, .005}),
			 ist::makeBoxMesh({.3, .01, .3}), ist::makeCylinderMesh(.02, .06), ist::makeConeMesh(.04, .08), ist::makeCapsuleMesh(.02, .04),
			 ist::makeTetrahedronMesh(.1), ist::makeTorusMesh(.04, .01, 48, 24), ist::makeTorusKnotMesh(.05, .02, .01, 2, 3, 200, 16)})
		solids.emplace_back(mesh, 300);
	constexpr double kRate = 60;
	int hits = 0, quarter = 0;
	double deepest = 0;
	uint64_t held = 0;
	for (int i = 0; i < 100; ++i)
	{
		std::mt19937 random{unsigned(i)};
		std::uniform_real_distribution<double> u(-1, 1);
		const auto some = [&] { return Vec3{u(random), u(random), u(random)}; };
		const auto reach = [](const Solid& solid) {
			double most = 0;
			for (const Vec3& p : solid.mesh.vertices) most = std::max(most, norm(p));
			return most;
		};
		const Solid &a = solids[random() % solids.size()], &b = solids[random() % solids.size()];
		const double speed = i % 2 ? 5 : 20, spin = i % 4 == 1 ? 30 : 0, sizes = reach(a) + reach(b);
		Scene scene;
		scene.world.setGravity(btVector3(0, 0, 0));
		scene.world.setLog([](const char*) {});
		const auto add = [&](const Solid& solid, const Vec3& place) {
			const double mass = 1000 * solid.tree->volume;
			btRigidBody* body = scene.add(scene.volumetricShape(solid), mass, 1, at(place, 3 * some()));
			const ist::Mat3& I = solid.tree->inertia;
			body->setMassProps(btScalar(mass), vec(1000 * Vec3{I.m[0][0], I.m[1][1], I.m[2][2]}));
			body->updateInertiaTensor();
			body->setAngularVelocity(vec(spin * some()));
			return body;
		};
		const auto energy = [](const btRigidBody* body) {
			const btVector3 w = body->getWorldTransform().getBasis().transpose() * body->getAngularVelocity();
			return .5 * body->getMass() * double(body->getLinearVelocity().length2()) + .5 * double((w * w).dot(body->getLocalInertia()));
		};
		const Vec3 place = 10 * some(), way = normalized(some()), side = some();
		const double gap = speed / kRate * (1.5 + .5 * u(random));
		btRigidBody* still = add(b, place);
		btRigidBody* fast = add(a, place - (sizes + gap) * way + .3 * sizes * (side - dot(side, way) * way));
		fast->setLinearVelocity(vec(speed * way));
		const double before = energy(still) + energy(fast);
		double most = 0;
		for (int step = 0; step < kRate * (2 * (sizes + gap) / speed + .15); ++step)
		{
			scene.step(1 / kRate);
			for (const btISTContact* c : scene.world.contacts().contacts())
				if (c->patchCount > 0 && !(c->ahead > 0)) most = std::max(most, c->depth / c->thickness());
			EXPECT_LT(energy(still) + energy(fast), before * (1 + 1e-4)) << i;
		}
		hits += norm(vec(fast->getLinearVelocity()) - speed * way) > .01 * speed;
		quarter += most > .25;
		deepest = std::max(deepest, most);
		held += scene.world.statistics().bodiesHeld;
	}
	EXPECT_GT(hits, 80);
	EXPECT_LE(quarter, 1) << "of " << hits;
	EXPECT_LT(deepest, .5) << "of " << hits;
	EXPECT_GT(held, 0u);
	// 20 to 44 in eight sets of impacts. Damping does not brake across a flat body, so that bodies spin on by up to two radians a step.
	EXPECT_LT(held, 60u);
}

// Ten rings are poured from up to 1.2 m (docs/stability.md). Impacts take few deep into each other: before steps were solved again for
// rings that others deflect, 66 contacts were deep in the mean of bins at 60 Hz.
TEST(DefaultContact, RingsThatArePouredIntoABinComeToRest)
{
	const double major = .05;
	const Solid ring(ist::makeTorusMesh(major, .015, 48, 24), 300);
	for (const auto& [rate, seeds] : {std::pair(60., 2), std::pair(240., 2)})
		for (int seed = 0; seed < seeds; ++seed)
		{
			std::mt19937 random{unsigned(seed)};
			std::uniform_real_distribution<double> u(-1, 1);
			Scene scene;
			scene.world.setGravity(btVector3(0, btScalar(-kGravity), 0));
			scene.addFloor();
			for (int side = -1; side <= 1; side += 2)
			{
				scene.add(scene.shape<btBoxShape>(btVector3(btScalar(.05), btScalar(.5), btScalar(.3))), 0, 0, at({.2 * side, .5, 0}));
				scene.add(scene.shape<btBoxShape>(btVector3(btScalar(.3), btScalar(.5), btScalar(.05))), 0, 0, at({0, .5, .2 * side}));
			}
			btCollisionShape* shape = scene.volumetricShape(ring);
			std::vector<btRigidBody*> rings;
			for (int i = 0; i < 10; ++i)
			{
				const double x = u(random), z = u(random), a = u(random), b = u(random), c = u(random);
				rings.push_back(scene.add(shape, .2, .2 * major * major, at({.03 * x, .15 + .12 * i, .03 * z}, {3 * a, 3 * b, 3 * c})));
			}
			const std::string where = "seed " + std::to_string(seed) + " at " + std::to_string(rate);
			int deep = 0;
			for (int step = 0; step < int(6 * rate); ++step)
			{
				scene.step(1 / rate);
				for (const btISTContact* contact : scene.world.contacts().contacts())
					deep += contact->patchCount > 0 && !(contact->ahead > 0) && contact->isDeep();
			}
			EXPECT_LT(deep, 25) << where;
			for (const btRigidBody* body : rings) EXPECT_LT(double(body->getLinearVelocity().length()), 1e-5) << where;
			for (const btISTContact* contact : scene.world.contacts().contacts())
			{
				if (contact->patchCount == 0 || contact->ahead > 0) continue;
				EXPECT_LT(contact->depth, .03 * contact->thickness()) << where;
			}
		}
}

// Bodies of eight kinds, thin and pointed ones among them, that fall upon each other at up to 8 m/s. Impacts may go a quarter deep for a
// moment, but all stay in the bin, and none stays caught in another one. What is no ball comes to rest.
TEST(DefaultContact, MixedBodiesThatArePouredIntoABinStayApartAndComeToRest)
{
	const Solid kinds[] = {{ist::makeBoxMesh({.04, .03, .02}), 500}, {ist::makeCylinderMesh(.02, .06), 500},
		{ist::makeConeMesh(.04, .08), 500}, {ist::makeCapsuleMesh(.02, .04), 500}, {ist::makeTetrahedronMesh(.1), 500},
		{ist::makeBoxMesh({.08, .006, .02}), 500}, {ist::makeTorusMesh(.04, .01, 48, 24), 500}, {ist::makeSphereMesh(.03), 500}};
	constexpr int kBins = 5;
	int binsAtRest = 0;
	uint64_t islands = 0, activeSetsNotFound = 0, frictionNotConverged = 0;
	for (int seed = 0; seed < kBins; ++seed)
	{
		std::mt19937 random{unsigned(seed)};
		std::uniform_real_distribution<double> u(-1, 1);
		Scene scene;
		scene.world.setGravity(btVector3(0, btScalar(-kGravity), 0));
		scene.addFloor();
		for (int side = -1; side <= 1; side += 2)
		{
			scene.add(scene.shape<btBoxShape>(btVector3(btScalar(.05), btScalar(2.5), btScalar(.3))), 0, 0, at({.2 * side, 2.5, 0}));
			scene.add(scene.shape<btBoxShape>(btVector3(btScalar(.3), btScalar(2.5), btScalar(.05))), 0, 0, at({0, 2.5, .2 * side}));
		}
		std::vector<btCollisionShape*> shapes;
		for (const Solid& kind : kinds) shapes.push_back(scene.volumetricShape(kind));
		std::vector<btRigidBody*> bodies;
		for (int i = 0; i < 16; ++i)
		{
			const ist::InnerSphereTree& tree = *kinds[i % 8].tree;
			const double mass = 1000 * tree.volume,
						 inertia = 1000. / 3 * (tree.inertia.m[0][0] + tree.inertia.m[1][1] + tree.inertia.m[2][2]);
			const double x = u(random), z = u(random), a = u(random), b = u(random), c = u(random);
			bodies.push_back(scene.add(shapes[size_t(i % 8)], mass, inertia, at({.05 * x, .15 + .2 * i, .05 * z}, {3 * a, 3 * b, 3 * c})));
		}
		int deep = 0;
		double deepest = 0;
		const auto countDeep = [&] {
			int count = 0;
			for (const btISTContact* contact : scene.world.contacts().contacts())
			{
				if (contact->patchCount == 0 || contact->ahead > 0) continue;
				count += contact->isDeep();
				deepest = std::max(deepest, contact->depth / contact->thickness());
			}
			return count;
		};
		for (int step = 0; step < 3 * 60; ++step)
		{
			scene.step(1. / 60);
			deep += countDeep();
		}
		EXPECT_LT(deep, 20) << seed;
		EXPECT_EQ(countDeep(), 0) << seed;
		EXPECT_LT(deepest, 0.3) << seed;
		const btVolumetricStatistics& statistics = scene.world.statistics();
		islands += statistics.islands;
		activeSetsNotFound += statistics.activeSetsNotFound;
		frictionNotConverged += statistics.frictionNotConverged;
		for (int step = 0; step < 4 * 60; ++step) scene.step(1. / 60);
		int moving = 0;
		for (size_t i = 0; i < bodies.size(); ++i)
		{
			const Vec3 p = vec(bodies[i]->getWorldTransform().getOrigin());
			EXPECT_TRUE(p.y > 0 && std::fabs(p.x) < .15 && std::fabs(p.z) < .15) << seed;
			const bool isBall = i % 8 == 7;
			moving += !isBall && bodies[i]->getLinearVelocity().length() > btScalar(1e-4);
		}
		binsAtRest += moving <= 3;
	}
	// In one bin of six a ball that rolls on keeps the pile at a creep of 1 mm/s (of 12 bins).
	EXPECT_GE(binsAtRest, kBins - 2);
	// Before patches became points, one in ten of the searches for those that push went round in circles.
	EXPECT_LT(50 * activeSetsNotFound, islands);
	// Before Newton's method, the search for friction ended early in most steps.
	EXPECT_LT(10 * frictionNotConverged, islands);
}

// Fixed pads hold a ball in the ground. What it presses there is not a load that a larger stiffness would lift.
TEST(DefaultContact, WhatIsClampedDoesNotPressMoreAndMore)
{
	const Solid ball(ist::makeSphereMesh(.03, 4), 400), pad(ist::makeBoxMesh({.01, .02, .03}), 100);
	for (const double rate : {60., 240., 1000.})
	{
		Scene scene;
		addSlab(scene);
		btRigidBody* body = scene.add(scene.volumetricShape(ball), .05, 1.8e-5, at({0, .0299, 0}));
		body->setFriction(btScalar(2));
		for (const double side : {-1., 1.})
			scene.add(scene.volumetricShape(pad), 0, 0, at({side * .0397, .0302, 0}))->setFriction(btScalar(2));
		scene.run(.05, rate);
		const double early = normalForceOn(scene, body, 1 / rate);
		scene.run(.5, rate);
		EXPECT_LT(normalForceOn(scene, body, 1 / rate), 5 * early) << rate;
		EXPECT_LT(body->getLinearVelocity().length(), 1e-3) << rate;
		EXPECT_LT(std::fabs(double(body->getWorldTransform().getOrigin().x())), 1e-4) << rate;
	}
}

// A world in centimetres, or with 1,024 units to the metre, moves as one in metres.
TEST(DefaultContact, UnitsOfLengthDoNotMatter)
{
	constexpr int kTimes = 12;
	double heights[3][kTimes], tilts[3][kTimes];
	const double units[3] = {1, 100, 1024};  // to the metre
	for (int u = 0; u < 3; ++u)
	{
		const double unit = units[u];
		const Solid ground(ist::makeBoxMesh(Vec3{1, .25, 1} * unit), 100),
			ring(upright(ist::makeTorusMesh(.15 * unit, .05 * unit, 48, 24)), 200);
		Scene scene;
		scene.world.bullet().setGravity(btVector3(0, btScalar(-kGravity * unit), 0));
		scene.add(scene.volumetricShape(ground), 0, 0, at(Vec3{0, -.25, 0} * unit));
		btRigidBody* body = scene.add(scene.volumetricShape(ring), 4, 4 * .01 * unit * unit, at(Vec3{0, .2, 0} * unit));
		for (int i = 0; i < kTimes; ++i)
		{
			scene.run(.1, 240);
			heights[u][i] = height(body) / unit;
			tilts[u][i] = tilt(body);
		}
		EXPECT_NEAR(heights[u][kTimes - 1], .05 * std::cos(std::numbers::pi / 24), 7e-4) << unit;  // on a facet, 0.55 mm deep in the mean
	}
	for (int u = 1; u < 3; ++u)
		for (int i = 0; i < kTimes; ++i)
		{
			EXPECT_NEAR(heights[u][i], heights[0][i], 2e-4) << units[u] << ' ' << i;
			EXPECT_NEAR(tilts[u][i], tilts[0][i], 2e-3) << units[u] << ' ' << i;
		}
}
