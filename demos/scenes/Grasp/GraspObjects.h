// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/TexturedMesh.h"

#include <string>
#include <vector>

namespace scenes
{
/// Something to be grasped: a closed mesh that stands on y = 0 and is gripped along z.
struct GraspObject
{
	std::string name;
	ist::Mesh mesh;
	double mass = 0;            ///< [kg]
	double gripHeight = 0;      ///< of the fingertips [m]
	double gripX = 0;           ///< middle between thumb and fingers, along x [m]
	double gripZ = 0;           ///< and along z
	double width = 0;           ///< along z, there [m]
	ist::TexturedMesh texture;  ///< its surface with places in a texture: of mug and ring, and of files that have some; else empty
};

/// "mug", "bunny", "duck", "nut", "plate", "ring".
const std::vector<std::string>& graspObjectNames();
/// Refused: another name; the bunny without the package that has it (glmark2-data).
ist::Result<GraspObject> makeGraspObject(const std::string& name);

/// A mesh from a file, whose y points up: repaired, set on y = 0, to be gripped across z at the height of its centre of mass. Its triangles
/// are divided until no edge is longer than 2 mm, for the sake of its heat map. `unit`: metres per unit of the file; 0: its longest side
/// becomes 0.1 m. 0.15 kg. Refused: what cannot be read or closed, and what is too wide for a hand.
ist::Result<GraspObject> loadGraspObject(const std::string& path, double unit);
}  // namespace scenes
