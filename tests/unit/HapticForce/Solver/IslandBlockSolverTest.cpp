// SPDX-License-Identifier: Zlib
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/HapticForce/Solver/IslandScene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

using namespace island;

// The oracle uses only which patches push. It solves for their impulses in a dense system (L_i + S_i sum W_ij L_j = push_i - S_i u_i).
// Every patch that the solver left out must pull when it is added, as a whole and as a point that pushes along its normal.
TEST(btIslandBlockSolver, AgreesWithADenseSolutionWithoutFriction)
{
	int pushing = 0, idle = 0, missed = 0, notFound = 0, points = 0;
	for (uint64_t seed = 1; seed <= 600; ++seed)
	{
		Scene scene = randomScene(seed, 0, std::pow(10.0, 2 + double(seed % 5)));
		btIslandBlockSolver solver;
		ASSERT_TRUE(scene.solve(solver));
		EXPECT_EQ(solver.sweeps(), 0) << "nothing rubs";
		scene.makePoints(solver);
		notFound += solver.activeSetNotFound();
		for (size_t k = 0; k < scene.contacts.size(); ++k) points += solver.isPoint(int(k));
		std::vector<size_t> active;
		for (size_t k = 0; k < scene.contacts.size(); ++k)
			if (solver.normalImpulse(int(k)) > 0) active.push_back(k);
		const Eigen::VectorXd exact = scene.denseImpulses(active);
		for (size_t i = 0; i < active.size(); ++i)
		{
			++pushing;
			const ist::Wrench got = solver.impulse(int(active[i]));
			EXPECT_LE((exact.segment<6>(Eigen::Index(6 * i)) - Scene::vec(got.force, got.torque)).norm(), 1e-8 * exact.norm())
				<< "seed " << seed;
			EXPECT_GT(exact.segment<3>(Eigen::Index(6 * i)).dot(Scene::eigen(scene.contacts[active[i]].patch.normal)), 0);
		}
		for (size_t k = 0; k < scene.contacts.size(); ++k)
		{
			if (solver.normalImpulse(int(k)) > 0) continue;
			++idle;
			EXPECT_EQ(norm(solver.impulse(int(k)).force) + norm(solver.impulse(int(k)).torque), 0);
			auto with = active;
			with.push_back(k);
			Scene asPoint = scene;
			asPoint.makePoint(asPoint.contacts[k].patch);
			for (const Scene* tried : {&scene, &asPoint})
				missed += tried->denseImpulses(with).tail<6>().head<3>().dot(Scene::eigen(scene.contacts[k].patch.normal)) > 0;
		}
	}
	EXPECT_GT(pushing, 1000);
	EXPECT_GT(idle, 200);
	EXPECT_EQ(missed, 0);
	EXPECT_EQ(notFound, 0);
	// A patch whose rotation alone would leave the contact, or for which no choice of the pushing ones is consistent, is a point.
	EXPECT_GT(points, 0);
	EXPECT_LT(points, 0.15 * (pushing + idle));
}

namespace
{
/// A body of 1 kg on the ground, under a body of 10,000 kg, with a patch at each corner of its bottom and of its top.
Scene squeezedScene(uint64_t seed)
{
	constexpr double kMass = 1e4, kSinkage = 0.01;
	Scene scene(seed, 0.01);
	for (const double mass : {1.0, kMass})
	{
		scene.addBody(mass);
		scene.bodies.back().center = scene.origin + ist::Vec3{0, 0, 0.5 + double(scene.bodies.size() - 1)};
		scene.free.back().linear.z -= 9.81 * kStep;
	}
	for (int level = 0; level < 2; ++level)
		for (const double x : {-0.4, 0.4})
			for (const double y : {-0.4, 0.4})
			{
				scene.addContact(level, level - 1, 1, 0.5);
				btContactPatch& patch = scene.contacts.back().patch;
				patch = {};
				patch.point = scene.origin + ist::Vec3{x, y, double(level)};
				patch.normal = normalized(ist::Vec3{0, 0, 1} + scene.vector(0.02));
				patch.wrench.force = 9.81 * kMass / 4 * patch.normal;
				patch.frictionRadius = 0.1;
				for (int axis = 0; axis < 3; ++axis)
				{
					for (int other = axis; other < 3; ++other)
						patch.stiffness(axis, other) = 9.81 * kMass / 4 / kSinkage * patch.normal[axis] * patch.normal[other];
					patch.stiffness(3 + axis, 3 + axis) = 9.81 * kMass / 4 / kSinkage / 100;
				}
			}
	return scene;
}
}  // namespace

// An error of 1e-9 of the forces from below and above would throw the light body about.
TEST(btIslandBlockSolver, LightBodyUnderAHeavyOneMovesAsItsImpulsesSay)
{
	for (uint64_t seed = 1; seed <= 40; ++seed)
	{
		const Scene scene = squeezedScene(seed);
		btIslandBlockSolver solver;
		ASSERT_TRUE(scene.solve(solver));
		const auto v = scene.after(solver);
		for (size_t k = 0; k < scene.contacts.size(); ++k)
		{
			const auto& c = scene.contacts[k];
			const ist::Wrench elastic = solver.elasticImpulse(int(k));
			const Vec6 expected = scene.push(c) - scene.S(c) * scene.relative(c, v);
			EXPECT_LE((Scene::vec(elastic.force, elastic.torque) - expected).norm(), 1e-8) << "seed " << seed << " patch " << k;
		}
	}
}

TEST(btIslandBlockSolver, AgreesWithARowOnOnePatch)
{
	for (uint64_t seed = 1; seed <= 20; ++seed)
	{
		Scene scene(seed);
		scene.addBody(1);
		scene.addBody(7);
		scene.addContact(0, 1, std::pow(10.0, double(seed % 7)), 0.5);
		btIslandBlockSolver solver;
		ASSERT_TRUE(scene.solve(solver));
		const auto& c = scene.contacts[0];
		btVolumetricRow row;
		row.prepare(c.patch, scene.bodies[0], scene.bodies[1], kStep, c.friction);
		Vec6 v[2] = {Scene::vec(scene.free[0].linear, scene.free[0].angular), Scene::vec(scene.free[1].linear, scene.free[1].angular)};
		for (int i = 0; i < 500; ++i)
		{
			const Vec6 u = scene.jacobian(c, 0) * v[0] - scene.jacobian(c, 1) * v[1];
			const ist::Wrench change = row.solve({{u(0), u(1), u(2)}, {u(3), u(4), u(5)}});
			const Vec6 w = Scene::vec(change.force, change.torque);
			v[0] += scene.inverseMass(0) * scene.jacobian(c, 0).transpose() * w;
			v[1] -= scene.inverseMass(1) * scene.jacobian(c, 1).transpose() * w;
		}
		const ist::Wrench a = solver.impulse(0), b = row.impulse();
		EXPECT_LE(norm(a.force - b.force) + norm(a.torque - b.torque), 1e-6 * (1e-3 + norm(b.force))) << "seed " << seed;
	}
}

// The weight is in equilibrium: the bottom carries all of it, at any ratio of the masses.
TEST(btIslandBlockSolver, StackCarriesItsWeightAtAnyMassRatio)
{
	for (const double top : {1.0, 1e2, 1e4, 1e6})
		for (const int count : {2, 10, 40})
		{
			btIslandBlockSolver solver;
			std::vector<ist::Twist> free;
			const double g = 9.81, k = 1e9;
			for (int i = 0; i < count; ++i)
			{
				const double mass = i == count - 1 ? top : 1;
				btVolumetricRowBody b;
				b.inverseMass = {1 / mass, 1 / mass, 1 / mass};
				for (int j = 0; j < 3; ++j) b.inverseInertia.m[j][j] = 6 / mass;
				b.center = {0, 0, i + 0.5};
				solver.addBody(b);
				free.push_back({{0, 0, -g * kStep}, {0, 0, 0}});
			}
			for (int i = 0; i < count; ++i)
			{
				btContactPatch p;
				p.point = {0, 0, double(i)};
				p.normal = {0, 0, 1};
				p.wrench.force = {0, 0, g * (count - 1 - i + top)};
				p.stiffness(2, 2) = k;
				p.stiffness(3, 3) = p.stiffness(4, 4) = k / 12;
				p.frictionRadius = 0.38;
				solver.addPatch(p, i, i - 1, {}, kStep, 0.5);
			}
			ASSERT_TRUE(solver.solve(free.data()));
			for (int i = 0; i < count; ++i)
				EXPECT_NEAR(solver.normalImpulse(i) / kStep / (g * (count - 1 - i + top)), 1, 1e-6) << count << " bodies, top " << top;
		}
}

// The envelope contains only the blocks of the bodies and of their pairs. This holds for one body held by all fingers of a hand, and for
// a stack.
TEST(btIslandBlockSolver, StarsAndStacksFillNothingIn)
{
	for (const int bodies : {3, 17})
		for (const bool star : {true, false})
			for (uint64_t seed = 1; seed <= 10; ++seed)
			{
				Scene scene(seed, 0);
				std::vector<int> order;
				for (int i = 0; i < bodies; ++i) order.push_back(scene.addBody(1));
				std::shuffle(order.begin(), order.end(), scene.random);
				for (int i = 1; i < bodies; ++i)
				{
					const int to = order[size_t(star ? 0 : i - 1)];
					for (int patch = 0; patch < 2; ++patch) scene.addContact(order[size_t(i)], to, 1000, 0.5);
				}
				scene.addContact(order[0], -1, 1000, 0.5);
				std::shuffle(scene.contacts.begin(), scene.contacts.end(), scene.random);
				btIslandBlockSolver solver;
				ASSERT_TRUE(scene.solve(solver));
				EXPECT_LE(solver.envelopeEntries(), 21 * bodies + 36 * (bodies - 1)) << (star ? "star" : "stack");
				EXPECT_GT(solver.envelopeEntries(), 21 * bodies + 36);
			}
}

namespace
{
/// A stack at rest under its weight but for pushes sideways.
Scene pushedTower(int bodies)
{
	Scene scene(1, 0);
	for (int i = 0; i < bodies; ++i)
	{
		const double load = 9.81 * (bodies - i);
		scene.addBody(1);
		scene.bodies.back().center = {0, 0, i + 0.5};
		scene.free.back().linear = {i % 3 == 0 ? 0.1 : 0.0, 0, -9.81 * kStep};
		scene.addContact(i, i - 1, 1, 0.3);
		btContactPatch& patch = scene.contacts.back().patch;
		patch = {};
		patch.point = {0, 0, double(i)};
		patch.normal = {0, 0, 1};
		patch.wrench.force = {0, 0, load};
		patch.stiffness(2, 2) = 1000 * load;
		patch.stiffness(3, 3) = patch.stiffness(4, 4) = 100 * load;
		patch.frictionRadius = 0.3;
	}
	return scene;
}
}  // namespace

// What is counted is all products of blocks: of the factorisation, of the inverse, of the answers to friction and of all sweeps. Each is so
// many for a body or a patch, whatever the height of the stack.
TEST(btIslandBlockSolver, WorkOfASweepGrowsWithTheHeightOfAStackAndNoFaster)
{
	for (const int bodies : {4, 8, 16, 32, 64})
	{
		const Scene scene = pushedTower(bodies);
		btIslandBlockSolver solver;
		ASSERT_TRUE(scene.solve(solver));
		EXPECT_GE(solver.sweeps(), 2) << bodies;
		// The bound below is that of one round without cuts of the friction.
		ASSERT_EQ(solver.rounds(), 0) << bodies;
		ASSERT_FALSE(solver.frictionNotConverged()) << bodies;
		const uint64_t substitutions = uint64_t(solver.sweeps()) + 2, patches = scene.contacts.size();
		const uint64_t once = 8 * uint64_t(bodies) + 4 * patches, each = 4 * uint64_t(bodies) + 2 * patches;
		EXPECT_LE(solver.products(), once + substitutions * each) << bodies;
		EXPECT_GE(solver.products(), substitutions * 4 * uint64_t(bodies - 1)) << bodies;
	}
}

TEST(btIslandBlockSolver, AllocatesNothingWithinWhatIsReserved)
{
	const Scene scenes[] = {pushedTower(8), heldScene(1), heldScene(6), randomScene(4, 0.9, 1e6), randomScene(5, 0.5, 1e4)};
	btIslandBlockSolver solver;
	solver.reserve(16, 24);
	const long before = allocationCount();
	int frictionSteps = 0;
	for (const Scene& scene : scenes)
	{
		ASSERT_TRUE(scene.solve(solver));
		frictionSteps += solver.frictionSteps();
	}
	EXPECT_EQ(allocationCount(), before);
	EXPECT_GT(frictionSteps, 0);
}

TEST(btIslandBlockSolver, LockedAxesDoNotMove)
{
	Scene scene(5);
	scene.addBody(1);
	scene.bodies[0].inverseMass = {1, 0, 1};
	scene.bodies[0].inverseInertia = ist::zeroMat3();
	scene.addContact(0, -1, 1e4, 0.5);
	scene.addContact(0, -1, 1e4, 0.5);
	btIslandBlockSolver solver;
	ASSERT_TRUE(scene.solve(solver));
	const auto v = scene.after(solver);
	EXPECT_EQ(v[0](1), scene.free[0].linear.y);
	EXPECT_TRUE(v[0].allFinite());
	EXPECT_GT(solver.normalImpulse(0) + solver.normalImpulse(1), 0);
}

TEST(btIslandBlockSolver, RefusesWhatIsNotFinite)
{
	Scene scene(6);
	scene.addBody(1);
	scene.addContact(0, -1, 1e4, 0.5);
	scene.contacts[0].patch.stiffness(0, 0) = std::nan("");
	btIslandBlockSolver solver;
	EXPECT_FALSE(scene.solve(solver));
	EXPECT_EQ(norm(solver.impulse(0).force), 0);
}
