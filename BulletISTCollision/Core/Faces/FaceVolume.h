// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/SymmetricMatrix3.h"
#include "BulletISTCollision/Core/Faces/ContactFaces.h"

namespace ist
{
/// The volume that closed surfaces enclose is, for every unit vector u, the integral of (x - o).u n.u over them, with any origin o. Faces
/// that are cut inexactly leave gaps, and each direction feels them differently: flat contact is exact along its normal and poor across it.
/// This class weights the three directions of the faces' own frame by the inverse of their error.
///
/// Call `addArea` for all faces, then `fit`, then `addCut` for all faces, then `finish`; then `of(face)` is a face's share of the volume.
class FaceVolume
{
public:
	void addArea(const ContactFace& face);
	void fit();
	void addCut(const ContactFace& face);
	void finish();
	/// Share of the face in the volume [m^3]; of either sign.
	double of(const ContactFace& face) const;
	/// Estimated variance of the volume, from the pieces that were cut at the other body's curved surface [m^6].
	double variance() const;
	/// Centroid of the faces [m].
	const Vec3& origin() const { return m_origin; }
	/// Area of the faces [m^2].
	double area() const { return m_area; }

private:
	double m_area = 0, m_variance[3] = {};
	Vec3 m_origin;               // centroid of the area
	SymmetricMatrix3 m_normals;  // integral of n n^T dS
	Vec3 m_axes[3];
	double m_weights[3] = {};
};
}  // namespace ist
