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

/// Closest point and winding number on a closed mesh, through a bounding volume hierarchy. Immutable after construction:
/// any number of threads may ask. Keeps its own copy of the mesh.
class MeshDistance
{
public:
	struct Closest
	{
		Vec3 point;             ///< on the surface
		double distance = 0;    ///< unsigned [m]
		uint32_t triangle = 0;  ///< lowest index among equally near ones
	};

	/// `threads`: of the construction; it changes nothing else.
	explicit MeshDistance(Mesh mesh, int threads = 1);
	~MeshDistance();
	MeshDistance(MeshDistance&&) noexcept;
	MeshDistance& operator=(MeshDistance&&) noexcept;

	const Mesh& mesh() const;

	/// O(log n). The search can be started from an upper bound of the distance; where nothing lies nearer than the bound,
	/// `distance` is the bound and `triangle` is UINT32_MAX.
	Closest closest(const Vec3& p, double upperBound = 1e300) const;

	/// Replaces `out` by the triangles within `reach` of p (unsigned distance [m], index), in no order to rely on; false, and `out` of no
	/// use, where there are more than `most`.
	bool within(const Vec3& p, double reach, size_t most, std::vector<std::pair<double, uint32_t>>& out) const;

	/// Generalised winding number: 1 inside, 0 outside a closed mesh (Jacobson et al. 2013), from exact solid angles of near
	/// triangles and the dipole expansion of far clusters (Barill et al. 2018). Error below 0.01 away from the surface.
	double windingNumber(const Vec3& p) const;

	/// windingNumber(p) > 0.5.
	bool contains(const Vec3& p) const;

	/// Negative inside.
	double signedDistance(const Vec3& p) const;

	/// Depth under the surface (> 0 inside, negative outside) and the unit outward normal n = -grad(depth) of the nearest surface
	/// point: the direction from p to it when inside, from it to p when outside; on the surface itself the triangle's normal.
	struct Field
	{
		double depth = 0;
		Vec3 normal;
	};
	Field field(const Vec3& p) const;
	/// The same when the caller knows on which side p lies (saves the winding number).
	Field field(const Vec3& p, bool inside) const;
	/// The same, bit for bit, and faster for many points close together: `hint` comes from the point before and is replaced by what helps
	/// the next. Start with UINT32_MAX.
	Field field(const Vec3& p, bool inside, uint32_t& hint) const;

private:
	struct Implementation;
	std::unique_ptr<Implementation> m_impl;
};
}  // namespace ist
