// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace ist
{
/// The closest point of a triangle to `p`, exact in double, robust for needles (Ericson, Real-Time Collision Detection, 5.1.5).
Vec3 closestPointOnTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Closest point and winding number on a closed mesh, computed through a bounding volume hierarchy. Immutable after construction: any
/// number of threads may query. Keeps its own copy of the mesh.
class MeshDistance
{
public:
	struct Closest
	{
		Vec3 point;             ///< on the surface
		double distance = 0;    ///< unsigned [m]
		uint32_t triangle = 0;  ///< lowest index among equally near triangles
	};

	/// `threads`: number of threads of the construction; the result does not depend on it.
	explicit MeshDistance(Mesh mesh, int threads = 1);
	~MeshDistance();
	MeshDistance(MeshDistance&&) noexcept;
	MeshDistance& operator=(MeshDistance&&) noexcept;

	const Mesh& mesh() const;

	/// Closest point of the mesh. O(log n). The search can start from an upper bound of the distance. If no point is nearer than the
	/// bound, `distance` is the bound and `triangle` is UINT32_MAX.
	Closest closest(const Vec3& p, double upperBound = 1e300) const;

	/// Replaces `out` by the triangles within `reach` of p (unsigned distance [m], index), in no defined order. False if there are more
	/// than `most`; `out` is then not valid.
	bool within(const Vec3& p, double reach, size_t most, std::vector<std::pair<double, uint32_t>>& out) const;

	/// Generalised winding number: 1 inside, 0 outside a closed mesh (Jacobson et al. 2013), from exact solid angles of near
	/// triangles and the dipole expansion of far clusters (Barill et al. 2018). Error below 0.01 away from the surface.
	double windingNumber(const Vec3& p) const;

	/// Whether windingNumber(p) > 0.5.
	bool contains(const Vec3& p) const;

	/// Distance to the surface, negative inside [m].
	double signedDistance(const Vec3& p) const;

	/// Depth under the surface [m] (> 0 inside, negative outside) and the unit outward normal n = -grad(depth) of the nearest surface
	/// point. The normal points from p to that point if p is inside, and from that point to p if p is outside. On the surface it is the
	/// triangle's.
	struct Field
	{
		double depth = 0;
		Vec3 normal;
	};
	Field field(const Vec3& p) const;
	/// Like field(p), for a caller that knows on which side p lies. This saves the winding number.
	Field field(const Vec3& p, bool inside) const;
	/// Bitwise equal to the function above, and faster for many points close together. `hint` comes from the previous call and is updated
	/// for the next. Start with UINT32_MAX.
	Field field(const Vec3& p, bool inside, uint32_t& hint) const;

private:
	struct Implementation;
	std::unique_ptr<Implementation> m_impl;
};
}  // namespace ist
