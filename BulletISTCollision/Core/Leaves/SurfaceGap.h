// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace ist
{
class NearestSphere;

/// Distance of the surface from the nearest sphere.
struct SurfaceGap
{
	double mean = 0;           ///< [m]
	double largest = 0;        ///< upper bound over the whole surface [m]
	double uncoveredArea = 0;  ///< share of the surface whose gap exceeds three times the mean
};

/// `threads`: 1 or more; the result does not depend on it.
SurfaceGap measureSurfaceGap(const Mesh& mesh, const NearestSphere& nearest, int threads);
}  // namespace ist
