// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/TexturedMesh.h"
#include "DeviceBridge/Hand/Grasp/HeatMapTexture.h"

#include <string>

namespace scenes
{
/// Values of a white texel in the written pictures.
struct TextureScales
{
	double impulse = 0;   ///< [N s/m^2]
	double pressure = 0;  ///< [Pa]
};

/// Paints a map into the texture of its object. Writes PATH.png in the fingers' colours, PATH-impulse.png and PATH-pressure.png in 16
/// bits of grey, and PATH.obj with PATH.mtl, which show the first picture on the mesh.
ist::Result<TextureScales> saveTextures(const devicebridge::HeatMap& map, const ist::TexturedMesh& surface, const std::string& path);
}  // namespace scenes
