// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace scenes
{
/// A mesh in the frame that Bullet needs for a body: the origin is the centre of mass, and the axes are the principal axes.
struct PrincipalMesh
{
	ist::Mesh mesh;
	ist::Pose X_MP;  ///< pose of the principal frame P in the frame M of the given mesh
};
PrincipalMesh inPrincipalFrame(const ist::Mesh& mesh);
}  // namespace scenes
