// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Vec3.h"
#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "BulletISTCollision/Core/Surface/DepthField.h"

#include <vector>

namespace ist
{
/// A convex polyhedron, as its faces. It begins as a box, and planes cut parts off.
class ConvexRegion
{
public:
	explicit ConvexRegion(const Box& box);

	struct Range
	{
		double low, high;
	};
	/// Least and largest distance of the region's points from the plane of a node [m].
	Range rangeOf(const DepthNode& node) const;
	/// Keeps the part on one side of the plane of a node: side 0 is that of the first child.
	void clip(const DepthNode& node, int side);

	using Polygon = std::vector<Vec3>;
	const std::vector<Polygon>& faces() const { return m_faces; }
	bool empty() const { return m_faces.empty(); }
	std::vector<Vec3> corners() const;  ///< of all faces: a corner comes once for each face that it belongs to
	Vec3 center() const;                ///< mean of the corners

private:
	std::vector<Polygon> m_faces;
};
}  // namespace ist
