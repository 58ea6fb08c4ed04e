// SPDX-License-Identifier: Zlib
#include "demos/scenes/Truth/ContinuumGrid.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "demos/scenes/Extremes/Continuity.h"
#include "demos/scenes/Truth/OverlapQuadrature.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

using namespace ist;
using namespace scenes;

namespace
{
bool everything(const Vec3&) { return true; }
}  // namespace

// A rod lying on a wide flat face: a cylinder's segment and a ball's cap.
TEST(ContinuumGrid, ARodOnAFlatHasTheVolumeOfItsSegment)
{
	const MeshDistance block(makeBoxMesh({0.06, 0.03, 0.06}));
	const RodProbe rod;
	const ContinuumGrid grid(block, {{-0.012, 0.024, -0.027}, {0.014, 0.031, 0.028}}, 2.5e-4, everything);
	for (const double depth : {0.0013, 0.003, 0.0051})
	{
		const double r = rod.radius, c = r - depth;
		const double segment = r * r * std::acos(c / r) - c * std::sqrt(r * r - c * c),
					 cap = std::numbers::pi * depth * depth * (r - depth / 3);
		const double volume = segment * 2 * rod.halfLength + cap;
		const ContinuumGrid::Sum sum = grid.overlap(rod, {0.0011, 0.03 + c, 0.0007}, {0, 0, 1});
		const double blur = 2.5e-4 / depth;
		EXPECT_NEAR(sum.volume, volume, (0.002 + blur * blur) * volume) << depth;
		EXPECT_LT(std::fabs(sum.onRod.x) + std::fabs(sum.onRod.z), 0.005 * volume) << depth;
		// Of the force half comes from the block's field, whose normal is y everywhere here; the other from the rod's.
		EXPECT_GT(sum.onRod.y, 0.9 * volume);
		EXPECT_LE(sum.onRod.y, sum.volume);
	}
}

TEST(ContinuumGrid, AgreesWithTheQuadratureAlongLines)
{
	const Mesh ring = makeTorusMesh(0.05, 0.02);
	const MeshDistance surface(ring);
	const RodProbe rod;
	const OverlapQuadrature quadrature(ring, makeCapsuleMesh(rod.radius, rod.halfLength, 96));
	const ContinuumGrid grid(surface, {{0.03, -0.03, 0.003}, {0.072, 0.03, 0.022}}, 5e-4, everything);
	std::mt19937_64 random(11);
	std::uniform_real_distribution<double> u(-1, 1);
	for (int i = 0; i < 3; ++i)
	{
		const Vec3 turn{0.3 * u(random), 0.3 * u(random), 0};
		const Pose X{rotationMatrix(quaternionFromRotationVector(turn + Vec3{1.2, 0, 0})),
			{0.05 + 0.004 * u(random), 0.004 * u(random), 0.025 + 0.001 * u(random)}};
		const QuadratureTruth truth = quadrature.integrate(X, {}, 90, 20000);
		const ContinuumGrid::Sum sum = grid.overlap(rod, X.translation, X.rotation * Vec3{0, 0, 1});
		ASSERT_GT(truth.volume, 1e-8);
		EXPECT_NEAR(sum.volume, truth.volume, 0.02 * truth.volume) << i;
		EXPECT_LT(norm(sum.onRod + truth.wrench().force), 0.02 * norm(truth.wrench().force)) << i;
	}
}

TEST(Continuity, PowerAboveAFrequencyIsHalfTheSquareOfASine)
{
	const double rate = 1000;
	const auto wave = [&](double frequency, double size) {
		std::vector<double> values;
		for (int i = 0; i < 700; ++i) values.push_back(3 + 0.02 * i + size * std::sin(2 * std::numbers::pi * frequency * i / rate + 0.4));
		return values;
	};
	EXPECT_NEAR(powerAbove(wave(80, 0.3), rate, 50), 0.3 * 0.3 / 2, 0.02 * 0.045);
	EXPECT_NEAR(powerAbove(wave(441, 0.3), rate, 50), 0.3 * 0.3 / 2, 0.02 * 0.045);
	EXPECT_LT(powerAbove(wave(20, 0.3), rate, 50), 1e-4 * 0.045);
	EXPECT_EQ(powerAbove({1, 2}, rate, 50), 0);
}
