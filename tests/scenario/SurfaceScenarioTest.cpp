// SPDX-License-Identifier: Zlib
// Contact of bodies whose trees have a surface, far shallower than the gaps between spheres.
#include "tests/scenario/VolumetricScene.h"

using namespace scenario;

namespace
{
constexpr double kGravity = 9.81, kHalf = 0.1, kMass = 8, kInertia = kMass * 4 * kHalf * kHalf / 6;

const Solid& sharpCube()
{
	static const Solid solid(ist::makeBoxMesh({kHalf, kHalf, kHalf}), 300);
	return solid;
}
}  // namespace

// With k on both bodies that of the pair is k / 2, and a flat contact of the area A carries F where it is F / (k A / 2) deep.
TEST(Surfaces, TowerSinksAsTheClosedFormSaysAndRests)
{
	const Solid slab(ist::makeBoxMesh({0.5, 0.1, 0.5}), 300);
	for (const double sinkage : {1e-3, 1e-4})
	{
		const double weight = kMass * kGravity, k = 2 * weight / (4 * kHalf * kHalf * sinkage);
		Scene scene;
		std::vector<btRigidBody*> bodies = {scene.add(scene.volumetricShape(slab), 0, 0, at({0, -0.1, 0}))};
		for (int i = 0; i < 3; ++i)
			bodies.push_back(scene.add(scene.volumetricShape(sharpCube()), kMass, kInertia, at({0, kHalf * (2 * i + 1) + 1e-4, 0})));
		for (btRigidBody* body : bodies) scene.setStiffness(body, k);
		scene.run(2, 240);
		double expected = 0;
		for (int i = 1; i <= 3; ++i)
		{
			expected += (4 - i) * sinkage;
			// The edges of a cube press less, by twice the share of the depth in its edge.
			EXPECT_NEAR(height(bodies[size_t(i)]), kHalf * (2 * i - 1) - expected, 0.05 * expected) << i << ' ' << sinkage;
			EXPECT_LT(tilt(bodies[size_t(i)]), sinkage) << i << ' ' << sinkage;
			EXPECT_LT(double(bodies[size_t(i)]->getLinearVelocity().length()), 1e-3) << i << ' ' << sinkage;
		}
	}
}

// One large face resists tilting with its whole area. Otherwise the box would rock on and on.
TEST(Surfaces, BoxThatWasPutDownTiltedComesToRest)
{
	const Solid slab(ist::makeBoxMesh({0.5, 0.1, 0.5}), 300);
	Scene scene;
	scene.setStiffness(scene.add(scene.volumetricShape(slab), 0, 0, at({0, -0.1, 0})), 1e7);
	btRigidBody* body = scene.add(scene.volumetricShape(sharpCube()), kMass, kInertia, at({0, kHalf + 0.006, 0}, {0.05, 0, 0.02}));
	scene.setStiffness(body, 1e7);
	scene.run(4, 60);
	EXPECT_LT(tilt(body), 2e-4);
	EXPECT_NEAR(height(body), kHalf, 1e-3);
	EXPECT_LT(double(body->getLinearVelocity().length()), 1e-4);
	EXPECT_LT(double(body->getAngularVelocity().length()), 1e-3);
}

// Bodies of all kinds fall into a heap. Surfaces lie in one another there, cross at edges, and are far deeper than in rest.
TEST(Surfaces, HeapStaysFiniteAndGainsNoEnergy)
{
	const Solid ring(ist::makeTorusMesh(0.09, 0.035, 24, 12), 300), cone(ist::makeConeMesh(0.1, 0.2, 24), 300);
	const Solid* kinds[] = {&sharpCube(), &ring, &cone};
	Scene scene;
	scene.addFloor();
	std::mt19937_64 random(7);
	std::vector<btRigidBody*> bodies;
	for (int i = 0; i < 27; ++i)
	{
		const ist::Vec3 place{0.37 * (i % 3), 0.3 + 0.37 * (i / 9), 0.37 * (i / 3 % 3)};
		bodies.push_back(
			scene.add(scene.volumetricShape(*kinds[i % 3]), 1, 0.007, at(place + randomVector(random, 0.01), randomVector(random, 2))));
	}
	const auto energy = [&] {
		double sum = 0;
		for (const btRigidBody* body : bodies)
			sum += kGravity * height(body) + 0.5 * double(body->getLinearVelocity().length2()) +
				0.5 * 0.007 * double(body->getAngularVelocity().length2());
		return sum;
	};
	const double start = energy();
	for (int i = 0; i < 120; ++i)
	{
		scene.step(1.0 / 60);
		ASSERT_LE(energy(), start * (1 + 1e-4)) << i;
	}
	for (const btRigidBody* body : bodies)
	{
		EXPECT_GT(height(body), 0);
		EXPECT_LT(double(body->getLinearVelocity().length()), 2);
	}
}
