// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/SymmetricMatrix3.h"

namespace ist
{
/// One smooth part of a surface, as a cloud of points sees it: means over the cloud. They change smoothly with the cloud's place, even
/// where the nearest point of the surface leaps (on an axis, at a centre).
struct FieldSide
{
	double depth = 0;       ///< mean depth below this side; negative outside [m]
	Vec3 normal;            ///< mean outward normal: unit length but where the cloud surrounds an axis or a centre
	SymmetricMatrix3 bend;  ///< derivative of the normal by place; positive semidefinite [1/m]
};

/// A convex body in closed form: the intersection of at most six sides, so that the depth at a point is the smallest over the
/// sides. The frame is the field's own; axes of revolution lie along z.
class AnalyticField
{
public:
	static constexpr int kMaxSides = 6;

	virtual ~AnalyticField() = default;
	virtual int sideCount() const = 0;
	/// Of a cloud of points about `p` with the covariance `spread` [m^2].
	virtual FieldSide side(int index, const Vec3& p, const SymmetricMatrix3& spread) const = 0;
	/// All sides are planes.
	virtual bool isPlanar() const { return false; }
	/// How far a cloud about `p` may reach along each axis for means to say enough about it [m].
	virtual Vec3 subdivisionSize(const Vec3& p) const = 0;
	/// [m^3]; infinite for a half-space.
	virtual double volume() const = 0;
	/// Every length positive and finite. The others are defined only then.
	virtual bool isValid() const = 0;

	/// Signed depth at a point: distance to the surface inside; outside, minus a lower bound of the distance [m].
	double depth(const Vec3& p) const;
	/// Unit outward normal of the nearest surface point, inside; any of them where there are several. Zero at a sphere's centre.
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

/// All points within `radius` of the segment from -halfHeight to halfHeight; a sphere when that is 0.
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

/// Base at z = -height / 2, apex at z = height / 2.
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
	double m_cos, m_sin;  // of the angle between axis and side
};
}  // namespace ist
