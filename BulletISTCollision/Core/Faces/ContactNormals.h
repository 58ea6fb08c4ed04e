// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Faces/ContactFaces.h"

namespace ist
{
/// Along what a part of a contact presses, where one body slides over the other.
///
/// By Gauss's theorem the pressures of all faces add up to the same force, whichever body's normals one takes: those of its faces, or the
/// gradient of its depth at the faces of the other. Face by face they differ, by 45 degrees at the edge of a cube. What single faces press
/// across the way on which the body slides adds up to nothing, but in patches, in a stiffness that is made positive, and in damping, it
/// brakes. So each part takes the normals of the body that is smoother, and in each direction across the mean normal those of the body that
/// is smoother there: a ball in a pipe, or a cube that stands on an edge across a pipe, slides along the pipe and around it.
///
/// Bodies that are about as smooth as each other, as a bolt and its nut, keep their own normals, and so do contacts at edges of both
/// bodies. Where the normals turn, the force found along them is off by about the depth over the radius of curvature. Up to 2 % they are
/// taken whole, from 3 % on not at all.
///
/// Use: `add` all faces of a part, `find`, `measure` all faces, `settle`.
class ContactNormals
{
public:
	void clear() { *this = {}; }
	/// `sign`: 1 for a face of B, -1 for one of A.
	void add(const ContactFace& face, double sign);
	/// `hasFacesA`, `hasFacesB`: whether the bodies have any. A half-space in closed form has none.
	void find(bool hasFacesA, bool hasFacesB);
	void measure(const ContactFace& face, double sign);
	void settle();

	/// Whether one body is clearly smoother. Otherwise each face presses along its own normal.
	bool exist() const { return m_smoother >= 0; }
	bool areOfA() const { return m_smoother == 0; }
	bool areOfB() const { return m_smoother == 1; }
	/// Whether the smoother one is a plane.
	bool areFlat() const { return exist() && m_areFlat; }
	/// How far the normals are taken, 0 to 1.
	double share() const { return m_share; }
	/// Unit vector from B to A at a face; zero where they do not exist.
	Vec3 at(const ContactFace& face, double sign) const;
	/// `v` along that vector; as it is where they do not exist.
	Vec3 along(const Vec3& v, const Vec3& normal) const;
	/// The pressure of a face along that vector. Its sum over the faces of a body has the size along the mean normal that it had.
	Vec3 pressure(const ContactFace& face, double sign, const Vec3& normal) const;

private:
	/// Sums over all faces of the normals of one body: of the faces' normals at its own, of the gradients at those of the other.
	struct Sum
	{
		Vec3 vector;
		double area = 0, ownArea = 0, gradients = 0;  // gradients: of the lengths
		SymmetricMatrix3 second;
		bool isCurved = false;

		void add(const Vec3& normal, double weight);
		/// How far the mean normal is from unit length, 0 on a plane.
		double spread() const;
		double across(const Vec3& a, const Vec3& b) const;
	};
	/// The directions in which one body is smoother than the other. Returns the mean square of what the smoother normals have across the
	/// mean.
	double findDirections(double& larger);

	Sum m_sums[2];  // of A, of B
	Vec3 m_mean, m_directions[2];
	int m_smoother = -1, m_smootherAcross[2] = {};
	bool m_areFlat = false, m_hasEdges = false;
	double m_share = 0;
	double m_before[2] = {}, m_after[2] = {};  // along the mean: sums of the pressures of A, of B
};
}  // namespace ist
