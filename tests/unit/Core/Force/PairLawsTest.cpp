// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Force/PairLaws.h"

#include "tests/unit/Core/Mesh/RandomShapes.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace ist
{
namespace
{
InnerSphereTree randomBody(uint64_t seed, int balls)
{
	std::mt19937_64 random(seed);
	std::uniform_real_distribution<float> u(-1, 1);
	InnerSphereTree tree;
	tree.origin = {0.3, -0.2, 0.1};
	std::vector<MomentEllipsoid> leaves;
	for (int i = 0; i < balls; ++i)
	{
		MomentEllipsoid b;
		b.x = u(random);
		b.y = u(random);
		b.z = u(random);
		b.R = 0.4f + 0.2f * u(random);
		b.density = 0.8f + 0.1f * u(random);
		b.nx = 0.5f * u(random);
		b.ny = 0.5f * u(random);
		b.nz = 0.5f * u(random);
		b.depth = 0.3f + 0.1f * u(random);
		giveRandomShape(b, random);
		leaves.push_back(b);
	}
	std::vector<Sphere> bounds;
	std::vector<StoredEllipsoid> ellipsoids;
	for (const MomentEllipsoid& b : leaves)
	{
		bounds.push_back({b.x, b.y, b.z, b.R});
		ellipsoids.emplace_back(b);
	}
	tree.law.balls = bounds;
	tree.law.ellipsoids = ellipsoids;
	return tree;
}

std::vector<OverlapPair> allPairs(size_t a, size_t b)
{
	std::vector<OverlapPair> pairs;
	for (uint32_t i = 0; i < a; ++i)
		for (uint32_t j = 0; j < b; ++j)
		{
			OverlapPair p;
			p.ballA = i;
			p.ballB = j;
			pairs.push_back(p);
		}
	return pairs;
}

TEST(PairLaws, EnergyForceIsTheGradient)
{
	const InnerSphereTree A = randomBody(1, 12), B = randomBody(2, 12);
	const std::vector<OverlapPair> pairs = allPairs(12, 12);
	const PressurePair pair{7, 0.3, 0.7};
	const auto law = [&](const Pose& X) { return energyLaw(A, B, X, pairs.data(), static_cast<int>(pairs.size()), pair); };
	for (int pose = 0; pose < 10; ++pose)
	{
		const double t = 0.17 * pose;
		const Pose X{rotationMatrix(quaternionFromRotationVector({t, 1 - t, 0.5})), {0.6 - t, 0.3, t}};
		const PairLawResult at = law(X);
		const double h = 1e-6;
		for (int axis = 0; axis < 3; ++axis)
		{
			Vec3 e;
			e[axis] = h;
			// Moving A by e is the same as moving B by -e, about A's origin for rotations.
			const auto moved = [&](double sign) { return law({X.rotation, X.translation - e * sign}).energy; };
			EXPECT_NEAR(at.wrench.force[axis], -(moved(1) - moved(-1)) / (2 * h), 1e-5 * norm(at.wrench.force));
			const auto turned = [&](double sign) {
				const Mat3 r = rotationMatrix(quaternionFromRotationVector(e * -sign));
				return law(Pose{Mat3(), A.origin} * Pose{r, {}} * Pose{Mat3(), -A.origin} * X).energy;
			};
			EXPECT_NEAR(at.wrench.torque[axis], -(turned(1) - turned(-1)) / (2 * h), 1e-5 * norm(at.wrench.torque) + 1e-7);
		}
	}
}

TEST(PairLaws, PaperForceOfTwoSpheres)
{
	InnerSphereTree A, B;
	A.inner = B.inner = buildInnerTree(std::vector<Sphere>{{0, 0.5f, 0, 1}});
	const std::vector<OverlapPair> pairs = allPairs(1, 1);
	const double d = 1.2;
	const Wrench w = paperLaw(A, B, {Mat3(), {d, 0, 0}}, pairs.data(), 1, 3).wrench;
	// This is the lens of two unit spheres at distance d.
	const double lens = std::numbers::pi * (4 + d) * (2 - d) * (2 - d) / 12;
	EXPECT_NEAR(w.force.x, -3 * lens, 1e-12);
	EXPECT_NEAR(w.force.y, 0, 1e-12);
	EXPECT_NEAR(w.torque.z, 0.5 * 3 * lens, 1e-12);
	EXPECT_EQ(norm(paperLaw(A, B, {Mat3(), {2.5, 0, 0}}, pairs.data(), 1, 3).wrench.force), 0);
}
}  // namespace
}  // namespace ist
