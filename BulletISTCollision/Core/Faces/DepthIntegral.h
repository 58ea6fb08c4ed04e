// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Faces/ContactFaces.h"

namespace ist
{
/// Integrals of the depths of A and B over a part of their overlap [m^4]: the energy of a contact for a stiffness of 1 Pa/m.
///
/// Two estimates are mixed. Columns stand on the faces and follow the depth's gradient to the body's own surface, which is exact where the
/// depth has no crease. Their volume tells how far this holds: the exact one is known. Cones join the faces with the middle of the part;
/// the depth in a cone is integrated from its values at the tip, on the face and at one point between (exact for cubic polynomials).
///
/// The mixture weighs them by these errors.
///
/// Call `begin`, then `add` for each face of the part, then `finish`. Neighbouring faces share a cone, which saves most of the lookups.
/// Frame: that of A. Cost: one lookup in each field for a cone, of which there are some hundred at most.
class DepthIntegral
{
public:
	/// Bodies of a query.
	struct Fields
	{
		const DepthField *A, *B;
		Pose X_BA;
	};

	/// `origin`: centroid of the faces. `area`: of all faces [m^2].
	void begin(const Fields& fields, const Vec3& origin, double area);
	/// `isOfB`: the face lies on B, inside A.
	void add(const Fields& fields, const ContactFace& face, bool isOfB);
	/// `volume`: of the part [m^3].
	void finish(const Fields& fields, double volume);

	double ofA() const { return m_sides[1].result; }
	double ofB() const { return m_sides[0].result; }

private:
	/// Faces that share a cone.
	struct Group
	{
		Vec3 first, normal;           ///< center and normal of the first face [m]
		Vec3 moment;                  ///< sum of size times center
		double size = 0, volume = 0;  ///< sums of |volume| and of volume
		bool isOpen = false;
	};
	/// Faces of one body, and the depth in the other one.
	struct Side
	{
		Group group;
		double columns = 0, energy = 0;  ///< integrals of 1 and of the depth over the columns
		double cones = 0;                ///< integral of the depth over the cones
		double atOrigin = 0, result = 0;
	};

	bool belongs(const Group& group, const ContactFace& face) const;
	void close(const Fields& fields, Group& group);
	double mixed(const Side& side, double volume) const;

	Vec3 m_origin;
	double m_reach = 0, m_volume = 0;  // squared radius of a group [m^2]; volume of the cones
	int m_count = 0;                   // of cones
	Side m_sides[2];                   // faces of A, faces of B
};
}  // namespace ist
