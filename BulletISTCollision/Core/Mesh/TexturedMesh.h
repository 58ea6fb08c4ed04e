// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace ist
{
/// A position in a texture: u to the right and v up, both from 0 to 1, from the lower left corner. Outside, the texture repeats.
struct TexturePlace
{
	double u = 0, v = 0;
};

/// A triangle mesh with texture coordinates. Corners of triangles that share a vertex may have different ones; a seam runs there.
struct TexturedMesh
{
	Mesh mesh;
	std::vector<std::array<TexturePlace, 3>> places;  ///< texture coordinates of each triangle's corners
};
}  // namespace ist
