// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/BallTree.h"

namespace ist
{
/// Mean distance by which leaves at the surface protrude along their normals, weighted by the surface that they cover [m]. A leaf lies at
/// the surface if its half-width along the normal exceeds its depth. 0 if no leaf does.
double surfaceResolution(const BallTree& law);
}  // namespace ist
