// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/Kernels/RowLanes.h"

// Included by QueryKernel.cpp only. Loads several ellipsoids side by side and rotates them.
namespace
{
struct F3
{
	F x, y, z;
};
IST_INLINE F3 cross(const F3& a, const F3& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
IST_INLINE F3 operator+(const F3& a, const F3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
IST_INLINE F3 operator*(const F& s, const F3& v) { return {s * v.x, s * v.y, s * v.z}; }
IST_INLINE F dot(const F3& a, const F3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

struct F6
{
	F xx, yy, zz, xy, xz, yz;
};
IST_INLINE F3 operator*(const F6& a, const F3& v)
{
	return {a.xx * v.x + a.xy * v.y + a.xz * v.z, a.xy * v.x + a.yy * v.y + a.yz * v.z, a.xz * v.x + a.yz * v.y + a.zz * v.z};
}
IST_INLINE F6 operator+(const F6& a, const F6& b) { return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz}; }
IST_INLINE F6 operator*(const F& s, const F6& a) { return {s * a.xx, s * a.yy, s * a.zz, s * a.xy, s * a.xz, s * a.yz}; }
IST_INLINE F trace(const F6& a) { return a.xx + a.yy + a.zz; }
IST_INLINE F6 adjugate(const F6& P)
{
	return {P.yy * P.zz - P.yz * P.yz, P.xx * P.zz - P.xz * P.xz, P.xx * P.yy - P.xy * P.xy, P.xz * P.yz - P.xy * P.zz,
		P.xy * P.yz - P.xz * P.yy, P.xy * P.xz - P.yz * P.xx};
}
/// `Q`: adjugate of P.
IST_INLINE F determinant(const F6& P, const F6& Q) { return P.xx * Q.xx + P.xy * Q.xy + P.xz * Q.xz; }

/// Trace of the product.
IST_INLINE F dot(const F6& a, const F6& b)
{
	const F off = a.xy * b.xy + a.xz * b.xz + a.yz * b.yz;
	return a.xx * b.xx + a.yy * b.yy + a.zz * b.zz + off + off;
}

struct Balls
{
	F x, y, z, R, density;
	F3 normal;
	F depth;
	F6 shape;
};

static_assert(sizeof(MomentEllipsoid) == 64 && sizeof(Sphere) == 16 && sizeof(StoredEllipsoid) == 32);

/// Loads centres, radii, depths and shapes; leaves density and normal empty.
IST_INLINE Balls fetchShapes(const MomentEllipsoid* balls, const uint32_t* index)
{
	constexpr int offset[3] = {0, 32, 48};
	F::Part c[12];
	fetchRows<3>(balls, index, offset, c);
	return {{c[0]}, {c[1]}, {c[2]}, {c[3]}, {}, {}, {c[4]}, {{c[6]}, {c[7]}, {c[8]}, {c[9]}, {c[10]}, {c[11]}}};
}

IST_INLINE Balls fetch(const MomentEllipsoid* balls, const uint32_t* index)
{
	constexpr int offset[4] = {0, 16, 32, 48};
	F::Part c[16];
	fetchRows<4>(balls, index, offset, c);
	return {
		{c[0]}, {c[1]}, {c[2]}, {c[3]}, {c[4]}, {{c[5]}, {c[6]}, {c[7]}}, {c[8]}, {{c[10]}, {c[11]}, {c[12]}, {c[13]}, {c[14]}, {c[15]}}};
}

/// Loads centres and radii; packed spheres have nothing else.
IST_INLINE Balls fetch(const Sphere* balls, const uint32_t* index)
{
	constexpr int offset[1] = {0};
	F::Part c[4];
	fetchRows<1>(balls, index, offset, c);
	return {{c[0]}, {c[1]}, {c[2]}, {c[3]}, {}, {}, {}, {}};
}

/// Value of one step of the numbers stored in a word.
constexpr float kStoredStep = StoredEllipsoid::kStep / 65536;

/// Shapes from their stored words. `R`: radii of the balls.
IST_INLINE F6 storedShape(const F& R, F xxyy, F zzxy, F xzyz)
{
	return R * R * F::all(kStoredStep) *
		F6{F::lowerNumber(xxyy), F::upperNumber(xxyy), F::lowerNumber(zzxy), F::upperNumber(zzxy), F::lowerNumber(xzyz),
			F::upperNumber(xzyz)};
}

/// Loads centres, radii and shapes; leaves density, normal and depth empty.
IST_INLINE Balls fetchShapes(const Sphere* balls, const StoredEllipsoid* ellipsoids, const uint32_t* index)
{
	constexpr int offset[1] = {offsetof(StoredEllipsoid, shape)};
	Balls b = fetch(balls, index);
	F::Part c[4];
	fetchRows<1>(ellipsoids, index, offset, c);
	b.shape = storedShape(b.R, {c[0]}, {c[1]}, {c[2]});
	return b;
}

IST_INLINE Balls fetch(const Sphere* balls, const StoredEllipsoid* ellipsoids, const uint32_t* index)
{
	constexpr int offset[2] = {0, offsetof(StoredEllipsoid, shape)};
	Balls b = fetch(balls, index);
	F::Part c[8];
	fetchRows<2>(ellipsoids, index, offset, c);
	const F step = F::all(kStoredStep), xy{c[2]}, z{c[3]};
	b.density = {c[0]};
	b.depth = {c[1]};
	b.normal = step * F3{F::lowerNumber(xy), F::upperNumber(xy), F::lowerNumber(z)};
	b.shape = storedShape(b.R, {c[4]}, {c[5]}, {c[6]});
	return b;
}

IST_INLINE F6 fetch(const NormalGradient* gradients, const uint32_t* index)
{
	constexpr int offset[1] = {0};
	F::Part c[4];
	fetchRows<1>(gradients, index, offset, c);
	const F words[3] = {{c[0]}, {c[1]}, {c[2]}};
	return {F::upperHalf(words[0]), F::upperHalf(words[1]), F::upperHalf(words[2]), F::lowerHalf(words[0]), F::lowerHalf(words[1]),
		F::lowerHalf(words[2])};
}

/// One component of a point of B's tree frame in A's. The order of operations is that of the reference.
IST_INLINE D movedComponent(const double* R, const double* t, int row, const D& x, const D& y, const D& z)
{
	return D::all(R[3 * row]) * x + D::all(R[3 * row + 1]) * y + D::all(R[3 * row + 2]) * z + D::all(t[row]);
}

IST_INLINE F3 turned(const double* R, const F3& v)
{
	const auto row = [&](int i) {
		return F::all(float(R[3 * i])) * v.x + F::all(float(R[3 * i + 1])) * v.y + F::all(float(R[3 * i + 2])) * v.z;
	};
	return {row(0), row(1), row(2)};
}

/// R^T v
IST_INLINE F3 turnedBack(const double* R, const F3& v)
{
	const auto column = [&](int i) { return F::all(float(R[i])) * v.x + F::all(float(R[3 + i])) * v.y + F::all(float(R[6 + i])) * v.z; };
	return {column(0), column(1), column(2)};
}

/// R P R^T
IST_INLINE F6 turned(const double* R, const F6& P)
{
	const auto row = [&](int i) { return F3{F::all(float(R[3 * i])), F::all(float(R[3 * i + 1])), F::all(float(R[3 * i + 2]))}; };
	const F3 x = row(0), y = row(1), z = row(2), Px = P * x, Py = P * y, Pz = P * z;
	return {dot(x, Px), dot(y, Py), dot(z, Pz), dot(x, Py), dot(x, Pz), dot(y, Pz)};
}
}  // namespace
