// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh.h"
#include "BulletISTCollision/Core/Result.h"

#include <string>
#include <vector>

namespace scenes
{
/// Something to be grasped: a closed mesh that stands on y = 0 and is gripped along z.
struct GraspObject
{
	std::string name;
	ist::Mesh mesh;
	double mass = 0;        ///< [kg]
	double gripHeight = 0;  ///< of the fingertips [m]
	double gripX = 0;       ///< middle between thumb and fingers, along x [m]
	double gripZ = 0;       ///< and along z
	double width = 0;       ///< along z, there [m]
};

/// "mug", "bunny", "duck", "nut", "plate", "ring".
const std::vector<std::string>& graspObjectNames();
/// Refused: another name; the bunny without the package that has it (glmark2-data).
ist::Result<GraspObject> makeGraspObject(const std::string& name);
}  // namespace scenes
