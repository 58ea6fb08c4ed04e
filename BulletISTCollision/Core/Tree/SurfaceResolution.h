// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/BallTree.h"

namespace ist
{
/// How far the leaves below the surface reach out of the body along their normals, mean over the surface they cover [m]. Leaves are told
/// to lie there by their half-width along the normal, which then exceeds their depth. 0 where none does.
double surfaceResolution(const BallTree& law);
}  // namespace ist
