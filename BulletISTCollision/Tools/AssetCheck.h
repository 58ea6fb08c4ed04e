// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Geometry/SpherePacking.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstdint>
#include <span>

namespace ist::tools
{
/// A proof on the stored spheres, tolerance zero. Shares no code with the packer, so that one cannot excuse the other.
struct OverlapFinding
{
	int64_t pairs = 0;
	double deepest = 0;    ///< [m]
	int64_t compared = 0;  ///< pairs that were looked at: what the search costs
};
OverlapFinding findOverlaps(std::span<const Sphere> spheres);

struct ProtrusionFinding
{
	int64_t spheres = 0;
	double farthest = 0;  ///< beyond the surface [m]
};
/// `mesh`: closed, oriented outwards, in the frame of the spheres.
ProtrusionFinding findProtrusions(std::span<const Sphere> spheres, const Mesh& mesh);
}  // namespace ist::tools
