// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/SymmetricMatrix3.h"
#include "BulletISTCollision/Core/Base/Vec3.h"

#include <cstdint>
#include <vector>

namespace ist
{
/// A triangle of the mesh, or a part of one.
struct SurfacePiece
{
	Vec3 corners[3];  ///< [m], counter-clockwise seen from outside
	Vec3 normal;      ///< unit length, outward
	double area = 0;  ///< [m^2]
	static constexpr uint32_t kNoRegion = 0xffffffffu;
	uint32_t region = kNoRegion;  ///< index of the flat region (FlatRegions.h) that the piece belongs to

	Vec3 centroid() const { return (corners[0] + corners[1] + corners[2]) / 3; }
};

double areaOfTriangle(const Vec3& a, const Vec3& b, const Vec3& c);

/// The normal of a cluster and its extent in the tangent plane.
struct ClusterFrame
{
	Vec3 normal;               ///< unit length
	Vec3 axes[2];              ///< principal axes of the position in the tangent plane, unit length, the longer extent first
	double variance[2] = {};   ///< of the position along the axes [m^2]
	Vec3 edges[2];             ///< half edges of a parallelogram with the same covariance and, nearly, the same outline [m]
	double curvature[3] = {};  ///< components 11, 12, 22 along the axes; positive where the surface is convex [1/m]
	double thickness = 0;      ///< variance of the position along the normal that the curvature does not explain [m^2]

	/// Half length along an axis of the rectangle that has the cluster's variance [m].
	double halfLength(int axis) const { return std::sqrt(3 * variance[axis]); }
};

/// A set of pieces and its moments. All means are weighted with the area.
struct SurfaceCluster
{
	std::vector<uint32_t> pieces;  ///< indices
	double area = 0;               ///< [m^2]
	Vec3 centroid;                 ///< [m]
	Vec3 normal;                   ///< mean of the outward normals
	SymmetricMatrix3 covariance;   ///< of the position [m^2]
	Vec3 tilt[3];                  ///< rows of the mean of n y^T, where y is the position from the centroid [m]
	ClusterFrame frame;
	double radius = 0;       ///< largest distance of a corner from the centroid [m]
	Vec3 ballCenter;         ///< of a ball around all corners [m]
	double ballRadius = 0;   ///< [m]
	double slenderness = 0;  ///< mean of (longest edge)^2 / area over the pieces
	bool isFlat = false;     ///< all pieces lie in one plane and face the same way
	std::vector<Vec3> face;  ///< corners of the convex polygon that the pieces of a flat cluster cover; empty if there is none

	/// Normal spread: 0 if all normals are equal, 1 if they cancel.
	double spread() const { return std::fmax(0, 1 - norm(normal)); }
	/// Mean of n (y . axis) [m].
	Vec3 tiltAlong(const Vec3& axis) const { return {dot(tilt[0], axis), dot(tilt[1], axis), dot(tilt[2], axis)}; }
};

SurfaceCluster clusterOf(const std::vector<SurfacePiece>& pieces, std::vector<uint32_t> members);

/// Principal axes of a symmetric matrix, the longest first.
struct PrincipalAxes
{
	Vec3 axes[3];
	double values[3];
};
PrincipalAxes principalAxes(const SymmetricMatrix3& matrix);
}  // namespace ist
