// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"

#include <cmath>

namespace ist
{
struct SymmetricMatrix3
{
	double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;

	static SymmetricMatrix3 identity(double factor = 1) { return {factor, factor, factor, 0, 0, 0}; }
	/// v v^T
	static SymmetricMatrix3 square(const Vec3& v) { return {v.x * v.x, v.y * v.y, v.z * v.z, v.x * v.y, v.x * v.z, v.y * v.z}; }

	SymmetricMatrix3& operator+=(const SymmetricMatrix3& o)
	{
		return *this = {xx + o.xx, yy + o.yy, zz + o.zz, xy + o.xy, xz + o.xz, yz + o.yz};
	}
	double trace() const { return xx + yy + zz; }
};

inline SymmetricMatrix3 operator+(SymmetricMatrix3 a, const SymmetricMatrix3& b) { return a += b; }
inline SymmetricMatrix3 operator*(const SymmetricMatrix3& a, double s)
{
	return {a.xx * s, a.yy * s, a.zz * s, a.xy * s, a.xz * s, a.yz * s};
}
inline Vec3 operator*(const SymmetricMatrix3& a, const Vec3& v)
{
	return {a.xx * v.x + a.xy * v.y + a.xz * v.z, a.xy * v.x + a.yy * v.y + a.yz * v.z, a.xz * v.x + a.yz * v.y + a.zz * v.z};
}
inline bool isFinite(const SymmetricMatrix3& a) { return std::isfinite(a.xx + a.yy + a.zz + a.xy + a.xz + a.yz); }
/// Trace of the product.
inline double dot(const SymmetricMatrix3& a, const SymmetricMatrix3& b)
{
	return a.xx * b.xx + a.yy * b.yy + a.zz * b.zz + 2 * (a.xy * b.xy + a.xz * b.xz + a.yz * b.yz);
}
/// Determinant times inverse.
inline SymmetricMatrix3 adjugate(const SymmetricMatrix3& a)
{
	return {a.yy * a.zz - a.yz * a.yz, a.xx * a.zz - a.xz * a.xz, a.xx * a.yy - a.xy * a.xy, a.xz * a.yz - a.xy * a.zz,
		a.xy * a.yz - a.xz * a.yy, a.xy * a.xz - a.yz * a.xx};
}
inline double determinant(const SymmetricMatrix3& a)
{
	const SymmetricMatrix3 q = adjugate(a);
	return a.xx * q.xx + a.xy * q.xy + a.xz * q.xz;
}
/// R A R^T
inline SymmetricMatrix3 rotated(const Mat3& R, const SymmetricMatrix3& a)
{
	const Vec3 x = a * R.row(0), y = a * R.row(1), z = a * R.row(2);
	return {dot(R.row(0), x), dot(R.row(1), y), dot(R.row(2), z), dot(R.row(0), y), dot(R.row(0), z), dot(R.row(1), z)};
}
}  // namespace ist
