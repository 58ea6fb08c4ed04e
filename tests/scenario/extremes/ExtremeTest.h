// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/MeshShapes.h"
#include "demos/scenes/ExtremeRows.h"

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

/// Edge 1 m.
inline const ExtremeSolid& unitCube()
{
	static const ExtremeSolid solid = solidOf(ist::makeBoxMesh({0.5, 0.5, 0.5}), 500);
	return solid;
}
}  // namespace extremes
