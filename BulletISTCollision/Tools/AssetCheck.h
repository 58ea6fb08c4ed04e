// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Geometry/SpherePacking.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

#include <cstdint>
#include <span>

namespace ist::tools
{
/// Check of the stored spheres with tolerance zero. It shares no code with the packer, so that an error in one cannot hide in the other.
struct OverlapFinding
{
	int64_t pairs = 0;
	double deepest = 0;    ///< [m]
	int64_t compared = 0;  ///< number of pairs that were compared: the cost of the search
};
OverlapFinding findOverlaps(std::span<const Sphere> spheres);

struct ProtrusionFinding
{
	int64_t spheres = 0;
	double farthest = 0;  ///< largest distance beyond the surface [m]
};
/// How far the stored surface is from closed. It is measured by integrals, which no element can satisfy alone.
struct SurfaceFinding
{
	double areaError = 0;  ///< difference between the area of the elements and that of the mesh, as a share of the latter
	double openArea = 0;   ///< length of the sum of area times normal, as a share of the area; zero for a closed surface
	bool holds() const;
};
SurfaceFinding checkSurface(const InnerSphereTree& tree);

/// `mesh`: closed, oriented outwards, in the frame of the spheres.
ProtrusionFinding findProtrusions(std::span<const Sphere> spheres, const Mesh& mesh);
}  // namespace ist::tools
