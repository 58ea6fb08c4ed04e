// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Distance/MeshDistance.h"

namespace scenes
{
/// How deep other meshes are in a closed one: distances on the triangles, nothing of packings or trees. Immutable.
class MeshDepth
{
public:
	explicit MeshDepth(const ist::Mesh& mesh);

	/// Depth of the deepest vertex of `other` below the surface; 0 when none is inside [m]. `X`: of `other` in the frame of this mesh.
	/// O(log n) for each of its vertices that is in the mesh's box.
	double deepest(const ist::Mesh& other, const ist::Pose& X) const;
	const ist::Mesh& mesh() const { return m_distance.mesh(); }
	/// Radius of the smallest ball about the frame's origin that holds the mesh [m].
	double reach() const { return m_reach; }

private:
	ist::MeshDistance m_distance;
	ist::Box m_box;
	double m_reach = 0;
};

/// The larger of how deep each is in the other; at once where their balls are apart.
double deepestEither(const MeshDepth& a, const ist::Pose& X_Wa, const MeshDepth& b, const ist::Pose& X_Wb);

/// Depth of the deepest vertex in a box about the origin of `X_WB` with these half sides; 0 when none is inside [m].
double deepestInBox(const ist::Vec3& half, const ist::Pose& X_WB, const ist::Mesh& mesh, const ist::Pose& X_WM);
}  // namespace scenes
