// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace scenes
{
/// A mesh as Bullet wants a body: the origin at the centre of mass, the axes along the principal ones.
struct PrincipalMesh
{
	ist::Mesh mesh;
	ist::Pose X_MP;  ///< of the principal frame P in that of the mesh M as given
};
PrincipalMesh inPrincipalFrame(const ist::Mesh& mesh);
}  // namespace scenes
