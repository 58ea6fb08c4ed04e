// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/TexturedMesh.h"
#include "DeviceBridge/Hand/Grasp/HeatMapTexture.h"

#include <string>

namespace scenes
{
/// What a white texel of the written pictures stands for.
struct TextureScales
{
	double impulse = 0;   ///< [N s/m^2]
	double pressure = 0;  ///< [Pa]
};

/// A map painted into the texture of its object: PATH.png in the fingers' colours, PATH-impulse.png and PATH-pressure.png in 16 bits of
/// grey, and PATH.obj with PATH.mtl, which show the first on the mesh.
ist::Result<TextureScales> saveTextures(const devicebridge::HeatMap& map, const ist::TexturedMesh& surface, const std::string& path);
}  // namespace scenes
