// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "BulletISTCollision/Core/Surface/DepthField.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace ist
{
/// The parts of the triangles of a mesh that lie in a node of the partition, in the order of the triangles. Each part is a convex polygon.
/// Exact but for roundings, for which a node may also hold parts just outside of it. Whole triangles take 8 bytes each.
class ClippedSurface
{
public:
	ClippedSurface() = default;
	/// All triangles of the mesh.
	explicit ClippedSurface(const Mesh& mesh);

	bool empty() const { return m_parts.empty(); }

	/// Calls visit(triangle, corners) for each part. `mesh`: that of the constructor.
	template <class Visit> void forEach(const Mesh& mesh, const Visit& visit) const
	{
		const Vec3* next = m_corners.data();
		for (const Part& part : m_parts)
		{
			if (part.corners > 0)
			{
				visit(size_t(part.triangle), std::span<const Vec3>(next, part.corners));
				next += part.corners;
				continue;
			}
			const auto& t = mesh.triangles[part.triangle];
			const Vec3 whole[3] = {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
			visit(size_t(part.triangle), std::span<const Vec3>(whole));
		}
	}

	/// The surfaces of both children of a node. `tolerance` is surfaceTolerance() of the mesh.
	std::pair<ClippedSurface, ClippedSurface> halves(const Mesh& mesh, const DepthNode& node, double tolerance) const;

private:
	struct Part
	{
		uint32_t triangle;
		uint32_t corners;  ///< 0: the whole triangle
	};
	void add(size_t triangle, std::span<const Vec3> corners, bool isWhole);
	void addClipped(size_t triangle, std::span<const Vec3> corners, const DepthNode& node, double sign, double tolerance);

	std::vector<Part> m_parts;
	std::vector<Vec3> m_corners;  ///< of all parts that are not whole triangles
};

/// Rounding of the distance of its points from a plane [m].
double surfaceTolerance(const Mesh& mesh);
}  // namespace ist
