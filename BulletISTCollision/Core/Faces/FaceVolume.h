// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/SymmetricMatrix3.h"
#include "BulletISTCollision/Core/Faces/ContactFaces.h"

namespace ist
{
/// The volume that closed surfaces enclose is, for every unit vector u, the integral of (x - o).u n.u over them, with any origin o. Faces
/// that are cut inexactly leave gaps along the rim of a contact, and each direction feels them differently: where the rim lies in a plane,
/// the direction across it does not; where faces lie along a cylinder, its axis does not. This class takes the rim's middle, its principal
/// axes, and those of the normals there, and weights the axes by the inverse of their error.
///
/// A sliver of a face that ends at a curved rim may be missing as a whole, as that of the ends of a cylinder that lies on a plane. Then the
/// axis across it says that there is no volume, and knows of no gap. So an axis along which all faces together cannot enclose what another
/// axis is sure of errs by as much as they lack.
///
/// Call `addArea` for all faces, then `fit`, then `add` for all faces, then `finish`.
class FaceVolume
{
public:
	void addArea(const ContactFace& face);
	void fit();
	void add(const ContactFace& face);
	void finish();
	/// [m^3]; of either sign.
	double volume() const { return m_volume; }
	/// Estimated variance of the volume, from the pieces that were cut at the other body's curved surface [m^6].
	double variance() const { return combined(m_variance); }
	/// The part of it that is of surfaces that are not exact: plane faces are cut exactly by planes.
	double inexactVariance() const { return combined(m_inexact); }
	/// Centroid of the faces [m].
	const Vec3& centroid() const { return m_centroid; }
	/// Area of the faces [m^2].
	double area() const { return m_area; }

private:
	static constexpr int kAxes = 6;

	double combined(const double (&variance)[kAxes]) const;

	double m_area = 0, m_volume = 0, m_variance[kAxes] = {}, m_inexact[kAxes] = {};
	double m_volumes[kAxes] = {}, m_mostVolumes[kAxes] = {};  // along each axis: what its faces enclose, and could at most
	Vec3 m_centroid, m_origin;
	double m_cuts = 0;           // sum of cut^2
	Vec3 m_rim;                  // sum of cut^2 x
	SymmetricMatrix3 m_spread;   // sum of cut^2 x x^T
	SymmetricMatrix3 m_normals;  // sum of cut^2 n n^T
	Vec3 m_axes[kAxes];
	double m_weights[kAxes] = {};
};
}  // namespace ist
