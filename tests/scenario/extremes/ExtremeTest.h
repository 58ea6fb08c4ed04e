// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "demos/scenes/Extremes/CubeTower.h"
#include "demos/scenes/Extremes/ExtremeRows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>

namespace extremes
{
using namespace scenes;
constexpr bool kDouble = sizeof(btScalar) == 8;
constexpr double kEpsilon = double(std::numeric_limits<btScalar>::epsilon());
constexpr double kGravity = 9.81;

inline ExtremeSolid solidOf(const ist::Mesh& mesh, int64_t spheres)
{
	ist::Result<ExtremeSolid> solid = makeExtremeSolid(mesh, spheres);
	if (solid) return std::move(solid).value();
	ADD_FAILURE() << solid.error().message;
	return {};
}

/// A cube with an edge of 1 m.
inline const ExtremeSolid& unitCube()
{
	static const ExtremeSolid solid = solidOf(ist::makeBoxMesh({0.5, 0.5, 0.5}), 500);
	return solid;
}

/// Each cube is turned by a quarter from the one below. Otherwise the bumps of their trees, which tilt a contact by about 1e-3 rad at
/// 10,000 spheres, would all tilt in the same direction. The tower must stand, and each layer must carry its weight according to the
/// model.
inline TowerOutcome expectStraightTower(TowerSetup setup, int64_t spheres)
{
	const ExtremeSolid cube = solidOf(ist::makeBoxMesh({0.5, 0.5, 0.5}), spheres);
	setup.turn = 1.5707963267948966;
	const TowerOutcome tower = stackCubes(Response::Volumetric, cube, setup);
	std::printf("  drift %.2e of an edge, force of a layer off by %.1e\n", tower.drift, tower.forceError);
	EXPECT_TRUE(tower.finite);
	EXPECT_LT(tower.fellAfter, 0);
	EXPECT_LT(tower.drift, 0.01);
	EXPECT_LT(tower.forceError, 0.01);
	return tower;
}
}  // namespace extremes
