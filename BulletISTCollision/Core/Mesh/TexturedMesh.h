// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace ist
{
/// A place in a picture: u to the right and v up, both from 0 to 1, from the lower left corner. Beyond, the picture repeats.
struct TexturePlace
{
	double u = 0, v = 0;
};

/// A triangle mesh that a picture is laid on. Corners of triangles that share a vertex may have different places: there runs a seam.
struct TexturedMesh
{
	Mesh mesh;
	std::vector<std::array<TexturePlace, 3>> places;  ///< of each triangle's corners
};
}  // namespace ist
