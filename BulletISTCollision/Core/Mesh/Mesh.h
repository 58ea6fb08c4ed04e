// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace ist
{
/// A triangle mesh as read: vertices [m] and triangles whose corners run counter-clockwise seen from outside. It need not be closed; see
/// MeshRepair.h.
struct Mesh
{
	std::vector<Vec3> vertices;
	std::vector<std::array<uint32_t, 3>> triangles;
	/// Distance between neighbouring values of the stored coordinates, as a share of the longest side. Corners that meet may differ by
	/// this rounding. importMesh() sets it from its file; the default is that of single precision near the origin.
	double rounding = 0x1p-23;
	/// One sentence for each kind of content of the file that was not imported. Set by importMesh(); not part of meshHash().
	std::vector<std::string> notTaken = {};
	/// Metres per unit of the file that importMesh() read; not part of meshHash().
	double unit = 1;
};

struct Box
{
	Vec3 lower, upper;
	Vec3 size() const { return upper - lower; }
	double longestSide() const
	{
		const Vec3 s = size();
		return s.x > s.y ? (s.x > s.z ? s.x : s.z) : (s.y > s.z ? s.y : s.z);
	}
	/// The axis of the longest side; the first of equal ones.
	int longestAxis() const
	{
		const Vec3 s = size();
		return s.x >= s.y && s.x >= s.z ? 0 : s.y >= s.z ? 1 : 2;
	}
};

/// Volume [m^3], centre of mass [m] and inertia about the centre of mass for density 1 [m^5] of a closed mesh, from the
/// divergence theorem (sum of signed tetrahedra about the centre of the bounding box, so that distance from the origin costs no digits).
struct MassProperties
{
	double volume = 0;
	Vec3 centerOfMass;
	Mat3 inertia = zeroMat3();
};

/// Axis-aligned bounds of the referenced vertices; both corners zero for an empty mesh.
Box bounds(const Mesh& mesh);
double surfaceArea(const Mesh& mesh);  ///< [m^2]
MassProperties massProperties(const Mesh& mesh);
Mesh transformed(const Mesh& mesh, const Pose& X);
Mesh translated(const Mesh& mesh, const Vec3& offset);
/// 64-bit FNV-1a hash of vertex coordinates (little-endian doubles) and indices. It identifies a source mesh.
uint64_t meshHash(const Mesh& mesh);
}  // namespace ist
