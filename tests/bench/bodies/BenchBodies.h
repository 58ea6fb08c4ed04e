// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <string>

namespace bench
{
/// Scales a mesh to a longest side of 1 and moves it off the origin.
ist::Mesh placed(ist::Mesh mesh);
/// The repaired bunny; empty if Debian's glmark2-data is not installed.
ist::Mesh bunnyMesh();
/// The mesh of a name, without scaling: bunny, box, torus, knot, jack, ellipsoid or ball; thin ones: plate, rod, wire (a knot), crown
/// or sword.
ist::Mesh meshNamed(const std::string& name);
}  // namespace bench
