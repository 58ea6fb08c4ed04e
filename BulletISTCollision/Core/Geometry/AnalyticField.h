// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/SymmetricMatrix3.h"

#include <variant>

namespace ist
{
/// Mean properties of one smooth part of a surface, taken over a cloud of points. They change smoothly with the cloud's position, even
/// where the nearest surface point jumps (on an axis, at a centre).
struct FieldSide
{
	double depth = 0;       ///< mean depth below this side; negative outside [m]
	Vec3 normal;            ///< mean outward normal; unit length unless the cloud surrounds an axis or a centre
	SymmetricMatrix3 bend;  ///< derivative of the normal by position; positive semidefinite [1/m]
};

/// A convex body in closed form: the intersection of at most six sides. So the depth at a point is the smallest depth over the sides. The
/// frame is the field's own; axes of revolution lie along z.
class AnalyticField
{
public:
	static constexpr int kMaxSides = 6;

	virtual ~AnalyticField() = default;
	virtual int sideCount() const = 0;
	/// A side, as means over a cloud of points about `p` with the covariance `spread` [m^2].
	virtual FieldSide side(int index, const Vec3& p, const SymmetricMatrix3& spread) const = 0;
	/// True if all sides are planes.
	virtual bool isPlanar() const { return false; }
	/// Largest half-width along each axis of a cloud about `p` whose means are accurate enough [m]. Larger clouds are subdivided.
	virtual Vec3 subdivisionSize(const Vec3& p) const = 0;
	/// Volume [m^3]; infinite for a half-space.
	virtual double volume() const = 0;
	/// True if every length is positive and finite. The other functions are defined only then.
	virtual bool isValid() const = 0;

	/// Signed depth at a point [m]. Inside, the distance to the surface; outside, minus a lower bound of the distance.
	double depth(const Vec3& p) const;
	/// Unit outward normal of the nearest surface point, for points inside. If there are several, any of them; zero at a sphere's centre.
	Vec3 normal(const Vec3& p) const;
};

/// { x : normal . x <= offset }, `normal` of unit length.
class HalfSpaceField : public AnalyticField
{
public:
	HalfSpaceField(const Vec3& normal, double offset) : m_normal(normal), m_offset(offset) {}
	int sideCount() const override { return 1; }
	FieldSide side(int index, const Vec3& p, const SymmetricMatrix3& spread) const override;
	bool isPlanar() const override { return true; }
	Vec3 subdivisionSize(const Vec3& p) const override;
	double volume() const override;
	bool isValid() const override;

private:
	Vec3 m_normal;
	double m_offset;
};

class BoxField : public AnalyticField
{
public:
	explicit BoxField(const Vec3& halfExtents) : m_half(halfExtents) {}
	int sideCount() const override { return 6; }
	FieldSide side(int index, const Vec3& p, const SymmetricMatrix3& spread) const override;
	bool isPlanar() const override { return true; }
	Vec3 subdivisionSize(const Vec3& p) const override;
	double volume() const override { return 8 * m_half.x * m_half.y * m_half.z; }
	bool isValid() const override;

private:
	Vec3 m_half;
};

/// All points within `radius` of the segment from -halfHeight to halfHeight on the z axis; a sphere if halfHeight is 0.
class CapsuleField : public AnalyticField
{
public:
	CapsuleField(double radius, double halfHeight) : m_radius(radius), m_half(halfHeight) {}
	int sideCount() const override { return 1; }
	FieldSide side(int index, const Vec3& p, const SymmetricMatrix3& spread) const override;
	Vec3 subdivisionSize(const Vec3& p) const override;
	double volume() const override;
	bool isValid() const override;

private:
	double m_radius, m_half;
};

class SphereField : public CapsuleField
{
public:
	explicit SphereField(double radius) : CapsuleField(radius, 0) {}
};

class CylinderField : public AnalyticField
{
public:
	CylinderField(double radius, double halfHeight) : m_radius(radius), m_half(halfHeight) {}
	int sideCount() const override { return 3; }
	FieldSide side(int index, const Vec3& p, const SymmetricMatrix3& spread) const override;
	Vec3 subdivisionSize(const Vec3& p) const override;
	double volume() const override;
	bool isValid() const override;

private:
	double m_radius, m_half;
};

/// A cone with its base at z = -height / 2 and its apex at z = height / 2.
class ConeField : public AnalyticField
{
public:
	ConeField(double radius, double height);
	int sideCount() const override { return 2; }
	FieldSide side(int index, const Vec3& p, const SymmetricMatrix3& spread) const override;
	Vec3 subdivisionSize(const Vec3& p) const override;
	double volume() const override;
	bool isValid() const override;

private:
	double radiusAt(double z) const { return m_radius * (0.5 - z / m_height); }

	double m_radius, m_height;
	double m_cos, m_sin;  // cosine and sine of the angle between axis and side
};

/// Any one of these bodies by value, or none.
using AnyField = std::variant<std::monostate, HalfSpaceField, BoxField, CapsuleField, CylinderField, ConeField>;

/// The body in `any`; null if there is none, or if one of its lengths is not positive and finite. Valid during the life of `any`.
const AnalyticField* fieldIn(const AnyField& any);
}  // namespace ist
