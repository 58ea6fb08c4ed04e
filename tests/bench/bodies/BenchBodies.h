// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <string>

namespace bench
{
/// Scaled to a longest side of 1, off the origin.
ist::Mesh placed(ist::Mesh mesh);
/// Repaired; empty where Debian's glmark2-data is not installed.
ist::Mesh bunnyMesh();
/// bunny, box, torus, knot, jack, ellipsoid or ball; thin ones: plate, rod, wire (a knot), crown or sword. As they come.
ist::Mesh meshNamed(const std::string& name);
}  // namespace bench
