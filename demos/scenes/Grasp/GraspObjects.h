// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/MeshAxes.h"
#include "BulletISTCollision/Core/Mesh/TexturedMesh.h"

#include <optional>
#include <string>
#include <vector>

namespace scenes
{
/// An object to grasp: a closed mesh that stands on y = 0 and is gripped along z.
struct GraspObject
{
	std::string name;
	ist::Mesh mesh;
	double mass = 0;            ///< [kg]
	double gripHeight = 0;      ///< height of the fingertips [m]
	double gripX = 0;           ///< middle between thumb and fingers, x [m]
	double gripZ = 0;           ///< middle between thumb and fingers, z [m]
	double width = 0;           ///< width along z at that height [m]
	ist::TexturedMesh texture;  ///< surface with texture coordinates, for the mug, the ring, and files that contain them; otherwise empty
	std::vector<ist::Vec3> fileVertices = {};  ///< vertices of the file in its order, of objects from files
};

/// Names: "mug", "bunny", "duck", "nut", "plate", "ring".
const std::vector<std::string>& graspObjectNames();
/// Makes an object. Refused: any other name, and the bunny without the package that contains it (glmark2-data).
ist::Result<GraspObject> makeGraspObject(const std::string& name);

/// How a file of an object is read.
struct GraspFile
{
	double unit = 0;                ///< unit of the file [m]; 0: the longest side becomes 0.1 m
	std::optional<ist::UpAxes> up;  ///< turn of the mesh; without it the file's y axis points up
	double mass = 0;                ///< [kg]; 0: 0.15 kg
};

/// Loads a mesh from a file. It is turned, repaired and set on y = 0. It will be gripped across z at the height of its
/// centre of mass. Its triangles are divided until no edge is longer than 2 mm, which the heat map needs.
///
/// Refused: a file that cannot be read, a mesh that cannot be closed, and one that is too wide for a hand. The last sentence names the
/// axes that, turned up, would make it narrow enough.
ist::Result<GraspObject> loadGraspObject(const std::string& path, const GraspFile& file = {});
}  // namespace scenes
