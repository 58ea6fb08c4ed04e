// SPDX-License-Identifier: Zlib
#include "TestSupport/SceneFiles/SceneShapes.h"

#include "BulletISTCollision/Core/Repair/MeshRepair.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

using namespace ist;
using namespace scenes;

namespace
{
void expectWhole(const Mesh& mesh)
{
	const Closedness found = inspect(mesh);
	EXPECT_TRUE(found.watertight);
	EXPECT_EQ(found.openEdges + found.nonManifoldEdges + found.flippedEdges + found.degenerateTriangles + found.duplicateTriangles, 0);
	EXPECT_EQ(found.components, 1);
	const Result<RepairedMesh> repaired = repair(mesh);
	ASSERT_TRUE(repaired) << repaired.error().message;
	EXPECT_TRUE(repaired.value().actions.empty()) << repaired.value().actions.front();
	EXPECT_EQ(repaired.value().cuts, 0);
}
}  // namespace

TEST(SceneShapes, ACrownIsWholeAndHasTheVolumeOfItsWall)
{
	for (const int points : {5, 16, 40})
	{
		CrownShape shape;
		shape.points = points;
		const Mesh mesh = makeCrownMesh(shape);
		expectWhole(mesh);
		// Int dtheta Int_0^h(theta) (R^2 - r(z)^2) / 2 dz with r linear in z, by Simpson's rule, which is exact for it.
		const int steps = 20000;
		double volume = 0;
		for (int i = 0; i < steps; ++i)
		{
			const double h = crownHeight(shape, 2 * std::numbers::pi * (i + 0.5) / steps);
			const auto share = [&](double z) { return (shape.radius * shape.radius - std::pow(crownInside(shape, z), 2)) / 2; };
			volume += 2 * std::numbers::pi / steps * h / 6 * (share(0) + 4 * share(h / 2) + share(h));
		}
		EXPECT_NEAR(massProperties(mesh).volume, volume, 0.015 * volume) << points;
		EXPECT_NEAR(bounds(mesh).upper.z, shape.bandHeight + shape.pointHeight, 1e-12);
		EXPECT_EQ(bounds(mesh).lower.z, 0);
	}
}

TEST(SceneShapes, ASwordIsWholeAndHasTheVolumeOfItsParts)
{
	const SwordShape s;
	const Mesh mesh = makeSwordMesh(s);
	expectWhole(mesh);
	// Rhombi of half diagonals a and b have the area 2ab; between two of them both grow linearly.
	const auto between = [](double a0, double b0, double a1, double b1, double length) {
		return 2 * length * (2 * a0 * b0 + 2 * a1 * b1 + a0 * b1 + a1 * b0) / 6;
	};
	const double tip = 0.04 * s.blade, g = s.gripHalfWidth, p = s.pommelHalfWidth;
	const double volume = between(0.02 * s.halfWidth, 0.02 * s.halfThickness, 0.5 * s.halfWidth, 0.5 * s.halfThickness, tip) +
		between(0.5 * s.halfWidth, 0.5 * s.halfThickness, s.halfWidth, s.halfThickness, 2 * tip) +
		2 * s.halfWidth * s.halfThickness * (s.blade - 3 * tip) + 2 * s.guardHalfWidth * s.guardHalfThickness * s.guardHeight +
		2 * g * g * s.grip + between(g, g, p, p, s.pommelHeight / 2) + between(p, p, g, g, s.pommelHeight / 2);
	EXPECT_NEAR(massProperties(mesh).volume, volume, 1e-9 * volume);
	const Vec3 size = bounds(mesh).size();
	EXPECT_NEAR(size.z, s.blade + s.guardHeight + s.grip + s.pommelHeight, 1e-12);
	EXPECT_NEAR(size.x, 2 * s.guardHalfWidth, 1e-12);
}

TEST(SceneShapes, ATubeIsWholeAndHasTheVolumeOfItsWall)
{
	for (const double chamfer : {0.0, 0.004})
	{
		TubeShape shape;
		shape.chamfer = chamfer;
		const Mesh mesh = makeTubeMesh(shape);
		expectWhole(mesh);
		const double inside = shape.radius - shape.wall, r = inside + chamfer;
		// A ring, without the frustum that widens the hole, on 96 chords instead of circles.
		const double chords = 96 * std::sin(2 * std::numbers::pi / 96) / (2 * std::numbers::pi);
		const double volume = std::numbers::pi *
			((shape.radius * shape.radius - inside * inside) * 2 * shape.halfLength -
				chamfer * ((r * r + r * inside + inside * inside) / 3 - inside * inside));
		EXPECT_NEAR(massProperties(mesh).volume, chords * volume, 1e-9 * volume);
		EXPECT_NEAR(bounds(mesh).upper.z, shape.halfLength, 1e-12);
		EXPECT_NEAR(bounds(mesh).upper.x, shape.radius, 1e-12);
	}
}
