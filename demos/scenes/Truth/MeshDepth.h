// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Distance/MeshDistance.h"

namespace scenes
{
/// Depth of other meshes in a closed one, from distances to the triangles, without packings or trees. Immutable.
class MeshDepth
{
public:
	explicit MeshDepth(const ist::Mesh& mesh);

	/// Depth of the deepest vertex of `other` below the surface [m]; 0 when no vertex is inside. `X` is the pose of `other` in the frame
	/// of this mesh. Cost: O(log n) for each vertex of `other` in the mesh's box.
	double deepest(const ist::Mesh& other, const ist::Pose& X) const;
	const ist::Mesh& mesh() const { return m_distance.mesh(); }
	/// Radius of the smallest ball about the frame's origin that contains the mesh [m].
	double reach() const { return m_reach; }

private:
	ist::MeshDistance m_distance;
	ist::Box m_box;
	double m_reach = 0;
};

/// The larger of the depths of each mesh in the other one [m]. Returns at once when their balls do not intersect.
double deepestEither(const MeshDepth& a, const ist::Pose& X_Wa, const MeshDepth& b, const ist::Pose& X_Wb);

/// Depth of the deepest vertex in a box about the origin of `X_WB` with these half sides [m]; 0 when no vertex is inside.
double deepestInBox(const ist::Vec3& half, const ist::Pose& X_WB, const ist::Mesh& mesh, const ist::Pose& X_WM);
}  // namespace scenes
