// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Faces/ContactFaces.h"

namespace ist
{
/// Points at which the depths of both bodies of a contact are sampled, those of all its parts together.
class ConePoints
{
public:
	/// `most`: largest number of points.
	explicit ConePoints(size_t most);
	void makeResident();

	void clear(const Pose& X_BA)
	{
		m_count = 0;
		m_X_BA = X_BA;
	}
	/// Adds a point of A's frame and returns its index. `part`: any number of the caller's.
	size_t add(const Vec3& point, double weight, uint32_t part);
	void setWeight(size_t point, double weight) { m_weight[point] = weight; }
	void sample(const BodySurface& A, const BodySurface& B, const kernels::QueryKernel& kernel);

	size_t count() const { return m_count; }
	double weight(size_t point) const { return m_weight[point]; }
	uint32_t part(size_t point) const { return m_part[point]; }
	/// Depth of a point [m], zero outside of the body; valid after `sample`.
	double depthInA(size_t point) const { return depths(0)[point]; }
	double depthInB(size_t point) const { return depths(1)[point]; }

private:
	static constexpr int kColumns = 4;  // of each body: x, y and z in its frame, and the depth
	float* column(int body, int i) { return m_numbers.data() + size_t(kColumns * body + i) * m_stride; }
	const float* depths(int body) const { return m_numbers.data() + size_t(kColumns * body + 3) * m_stride; }

	DemandZeroArray<float> m_numbers;
	DemandZeroArray<double> m_weight;
	DemandZeroArray<uint32_t> m_part;
	size_t m_count = 0, m_stride = 0;
	Pose m_X_BA;
};

/// Integrals of the depths of A and B over a part of their overlap [m^4]: the energy of a contact for a stiffness of 1 Pa/m.
///
/// Two estimates are mixed. Columns stand on the faces and follow the depth's gradient to the body's own surface, which is exact where the
/// depth has no crease. Their volume tells how far this holds: the exact one is known. Where they miss some, cones join the faces with the
/// middle of the part; the depth in a cone is integrated from its values at the tip, on the face and at one point between (exact for cubic
/// polynomials). The mixture weighs both by their errors.
///
/// Call `begin`, then `addColumn` for each face of the part. If `needsCones`, call `beginCones`, `addCone` for each face, `finishCones`,
/// and after the points were sampled `addSample` for each of the part's. Then call `finish`. Frame: that of A.
/// Cost: one sample of each depth for a cone, of which there are at most as many as faces; shallow contact of smooth bodies has none.
class DepthIntegral
{
public:
	void begin() { *this = {}; }
	/// `isOfB`: the face lies on B, inside A.
	void addColumn(const ContactFace& face, bool isOfB);
	/// `volume`: of the part [m^3].
	bool needsCones(double volume) const;
	/// `origin`: centroid of the faces. `area`: of all faces [m^2]. `part`: number of the part in `points`.
	void beginCones(const Vec3& origin, double area, uint32_t part, ConePoints& points);
	void addCone(const ContactFace& face, bool isOfB, ConePoints& points);
	void finishCones(ConePoints& points);
	void addSample(const ConePoints& points, size_t point);
	/// `volume`: of the part [m^3].
	void finish(double volume);

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
		double result = 0;
	};

	bool belongs(const Group& group, const ContactFace& face) const;
	void close(Group& group, ConePoints& points);
	double mixed(const Side& side, double volume) const;

	Vec3 m_origin;
	double m_reach = 0, m_volume = 0;  // squared radius of a group [m^2]; volume of the cones
	int m_count = 0;                   // of cones
	uint32_t m_part = 0;
	size_t m_tip = 0;  // point of m_origin
	Side m_sides[2];   // faces of A, faces of B
};
}  // namespace ist
