// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/DemandZeroArray.h"
#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Base/SymmetricMatrix3.h"
#include "BulletISTCollision/Core/Surface/BodySurface.h"

#include <cstddef>
#include <cstdint>

namespace ist
{
/// A piece of a body's surface that lies inside the other body: of an element, or of a part of one. d: depth in the other body; n: outward
/// normal of the surface.
struct ContactFace
{
	Vec3 center;               ///< centroid of the area [m]
	Vec3 areaNormal;           ///< integral of n dS [m^2]
	Vec3 pressure;             ///< integral of d n dS [m^3]; surfaceOverlap turns it along the normals of ContactNormals
	Vec3 pressureCenter;       ///< centroid of d dS [m]
	Vec3 gradient;             ///< of d, at the center
	Mat3 spread = zeroMat3();  ///< integral of (x - center) n^T dS [m^3]
	SymmetricMatrix3 second;   ///< integral of (x - center) (x - center)^T dS [m^4]; zero for surfaces that lie in each other
	double area = 0;           ///< [m^2]
	double depth = 0;          ///< integral of d dS [m^3]
	double cut = 0;            ///< area times the share of the piece that lies outside of the other body [m^2]; 0 for a whole piece
	double error = 0;          ///< standard error of d: that of the surface and that of the other body's depth [m]; set by surfaceOverlap
	uint32_t element = 0;      ///< of the surface
	uint32_t cell = 0;         ///< of the field, at a point of the piece
};

/// Whether n is the same all over the face.
inline bool isFlat(const ContactFace& face)
{
	for (const auto& row : face.spread.m)
		for (const double x : row)
			if (x != 0) return false;
	return true;
}

/// Work done by collectFaces, independent of the machine and of the instruction set.
struct FaceCounts
{
	int64_t nodes = 0;                        ///< nodes of the surface's tree, of four children each
	int64_t elements = 0;                     ///< elements that may lie inside
	int64_t quarters = 0;                     ///< quarters of elements
	int64_t planes = 0, cuts = 0, cells = 0;  ///< planes of the partition that were tested for polygons, cuts by them, polygons in a cell
	int64_t halvings = 0;                     ///< of polygons at a zero level that is too curved
};

/// List of faces with a fixed capacity. What does not fit is counted and left out.
struct FaceList
{
	DemandZeroArray<ContactFace> faces;
	size_t count = 0, dropped = 0;
	size_t most = SIZE_MAX;  ///< with more faces, collectFaces ends early, and the list is useless
	FaceCounts counts;

	/// `mostFaces` negative: no limit.
	void clear(int64_t mostFaces = -1)
	{
		count = dropped = 0;
		most = mostFaces < 0 ? SIZE_MAX : size_t(mostFaces);
		counts = {};
	}
	bool isOverLimit() const { return count + dropped > most; }
	ContactFace* next()
	{
		if (count < faces.size()) return &(faces[count++] = {});
		++dropped;
		return nullptr;
	}
};

namespace kernels
{
struct FieldTables;
struct QueryKernel;
}  // namespace kernels

kernels::FieldTables fieldTablesOf(const BodySurface& body);

/// How much depths in the body may be off by single precision: it grows with the body's size [m].
double depthRounding(const BodySurface& body);

/// Appends the faces of `pressing` inside `pressed`, in the frame of the latter. X_FS: pose of the former's frame in the latter's. All
/// kernels find the same faces in the same order.
///
/// The depth is sampled at four points of each element, and a quadratic function of the element's coordinates goes through the samples.
/// Elements at the rim of the contact that it does not fit are quartered. Elements are cut exactly at the planes of the field's partition
/// where they are larger than the cells, and where cells without error meet.
/// No allocation. What does not fit is counted in `FaceList::dropped`, and `FaceList::most` ends the search. O(faces + log n).
void collectFaces(
	const BodySurface& pressing, const BodySurface& pressed, const Pose& X_FS, const kernels::QueryKernel& kernel, FaceList& list);
}  // namespace ist
