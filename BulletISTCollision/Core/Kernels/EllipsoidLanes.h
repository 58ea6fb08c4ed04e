// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Kernels/FloatVector.h"
#include "BulletISTCollision/Core/Kernels/QueryKernel.h"

// Included by QueryKernel.cpp only. Several ellipsoids side by side, and the turning of them.
namespace
{
using namespace ist;
using namespace ist::kernels;

using F = FloatVector<kLanes>;

struct F3
{
	F x, y, z;
};
IST_INLINE F3 cross(const F3& a, const F3& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
IST_INLINE F dot(const F3& a, const F3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

struct F6
{
	F xx, yy, zz, xy, xz, yz;
};
IST_INLINE F3 operator*(const F6& a, const F3& v)
{
	return {a.xx * v.x + a.xy * v.y + a.xz * v.z, a.xy * v.x + a.yy * v.y + a.yz * v.z, a.xz * v.x + a.yz * v.y + a.zz * v.z};
}

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

static_assert(sizeof(MomentEllipsoid) == 64 && sizeof(Sphere) == 16);

/// Where each of kLanes balls begins.
struct Places
{
	const char* ball[kLanes];
};

template <class Ball>
IST_INLINE Places placesOf(const Ball* balls, const uint32_t* index)
{
	Places p;
	IST_UNROLL
	for (int k = 0; k < kLanes; ++k) p.ball[k] = reinterpret_cast<const char*>(balls + index[k]);
	return p;
}

/// Columns 0..3 of the rows of four floats that begin `offset` floats into each ball.
IST_INLINE void fetchRow(const Places& places, int offset, F& c0, F& c1, F& c2, F& c3)
{
#if defined(IST_SSE)
	const auto row = [&](int k) __attribute__((always_inline)) { return _mm_loadu_ps(reinterpret_cast<const float*>(places.ball[k]) + offset); };
#if defined(__AVX512VL__)
	const auto rows = [&](int k) __attribute__((always_inline)) {
		__m512 r = _mm512_castps128_ps512(row(k));
		r = _mm512_insertf32x4(r, row(k + 4), 1);
		r = _mm512_insertf32x4(r, row(k + 8), 2);
		return _mm512_insertf32x4(r, row(k + 12), 3);
	};
	const __m512 r0 = rows(0), r1 = rows(1), r2 = rows(2), r3 = rows(3);
	const __m512d a = _mm512_castps_pd(_mm512_unpacklo_ps(r0, r1)), b = _mm512_castps_pd(_mm512_unpackhi_ps(r0, r1));
	const __m512d c = _mm512_castps_pd(_mm512_unpacklo_ps(r2, r3)), d = _mm512_castps_pd(_mm512_unpackhi_ps(r2, r3));
	c0.part[0] = (F::Part)_mm512_unpacklo_pd(a, c);
	c1.part[0] = (F::Part)_mm512_unpackhi_pd(a, c);
	c2.part[0] = (F::Part)_mm512_unpacklo_pd(b, d);
	c3.part[0] = (F::Part)_mm512_unpackhi_pd(b, d);
#elif defined(__AVX2__)
	const auto rows = [&](int k) __attribute__((always_inline)) { return _mm256_insertf128_ps(_mm256_castps128_ps256(row(k)), row(k + 4), 1); };
	const __m256 r0 = rows(0), r1 = rows(1), r2 = rows(2), r3 = rows(3);
	const __m256d a = _mm256_castps_pd(_mm256_unpacklo_ps(r0, r1)), b = _mm256_castps_pd(_mm256_unpackhi_ps(r0, r1));
	const __m256d c = _mm256_castps_pd(_mm256_unpacklo_ps(r2, r3)), d = _mm256_castps_pd(_mm256_unpackhi_ps(r2, r3));
	c0.part[0] = (F::Part)_mm256_unpacklo_pd(a, c);
	c1.part[0] = (F::Part)_mm256_unpackhi_pd(a, c);
	c2.part[0] = (F::Part)_mm256_unpacklo_pd(b, d);
	c3.part[0] = (F::Part)_mm256_unpackhi_pd(b, d);
#else
	__m128 r0 = row(0), r1 = row(1), r2 = row(2), r3 = row(3);
	_MM_TRANSPOSE4_PS(r0, r1, r2, r3);
	c0.part[0] = (F::Part)r0;
	c1.part[0] = (F::Part)r1;
	c2.part[0] = (F::Part)r2;
	c3.part[0] = (F::Part)r3;
#endif
#else
	for (int k = 0; k < kLanes; ++k)
	{
		float row[4];
		std::memcpy(row, places.ball[k] + 4 * offset, sizeof row);
		c0.part[0][k] = row[0];
		c1.part[0][k] = row[1];
		c2.part[0][k] = row[2];
		c3.part[0][k] = row[3];
	}
#endif
}

/// The reverse of fetchRow: row k from lane k of the columns, into the ball at index k from `balls` on.
IST_INLINE void storeRow(MomentEllipsoid* balls, int offset, const F& c0, const F& c1, const F& c2, const F& c3)
{
	alignas(64) float column[4][kLanes];
	c0.store(column[0]);
	c1.store(column[1]);
	c2.store(column[2]);
	c3.store(column[3]);
#if defined(IST_SSE)
	for (int k = 0; k < kLanes; k += 4)
	{
		__m128 r0 = _mm_load_ps(column[0] + k), r1 = _mm_load_ps(column[1] + k), r2 = _mm_load_ps(column[2] + k), r3 = _mm_load_ps(column[3] + k);
		_MM_TRANSPOSE4_PS(r0, r1, r2, r3);
		float* const to = reinterpret_cast<float*>(balls + k) + offset;
		constexpr int kStride = sizeof(MomentEllipsoid) / sizeof(float);
		_mm_store_ps(to, r0);
		_mm_store_ps(to + kStride, r1);
		_mm_store_ps(to + 2 * kStride, r2);
		_mm_store_ps(to + 3 * kStride, r3);
	}
#else
	for (int k = 0; k < kLanes; ++k)
	{
		const float row[4] = {column[0][k], column[1][k], column[2][k], column[3][k]};
		std::memcpy(reinterpret_cast<char*>(balls + k) + 4 * offset, row, sizeof row);
	}
#endif
}

/// Without density and normal.
IST_INLINE Balls fetchEllipsoids(const Places& places)
{
	Balls b;
	F sphere;
	fetchRow(places, 0, b.x, b.y, b.z, b.R);
	fetchRow(places, 8, b.depth, sphere, b.shape.xx, b.shape.yy);
	fetchRow(places, 12, b.shape.zz, b.shape.xy, b.shape.xz, b.shape.yz);
	return b;
}
IST_INLINE Balls fetchEllipsoids(const MomentEllipsoid* balls, const uint32_t* index) { return fetchEllipsoids(placesOf(balls, index)); }

IST_INLINE Balls fetch(const MomentEllipsoid* balls, const uint32_t* index)
{
	const Places places = placesOf(balls, index);
	Balls b = fetchEllipsoids(places);
	fetchRow(places, 4, b.density, b.normal.x, b.normal.y, b.normal.z);
	return b;
}

/// Packed spheres are wholly filled and have no normal: just place and radius.
IST_INLINE Balls fetch(const Sphere* spheres, const uint32_t* index)
{
	Balls b;
	fetchRow(placesOf(spheres, index), 0, b.x, b.y, b.z, b.R);
	return b;
}

IST_INLINE F3 turned(const double* R, const F3& v)
{
	const auto row = [&](int i) {
		return F::all(float(R[3 * i])) * v.x + F::all(float(R[3 * i + 1])) * v.y + F::all(float(R[3 * i + 2])) * v.z;
	};
	return {row(0), row(1), row(2)};
}

/// R P R^T
IST_INLINE F6 turned(const double* R, const F6& P)
{
	const auto row = [&](int i) {
		return F3{F::all(float(R[3 * i])), F::all(float(R[3 * i + 1])), F::all(float(R[3 * i + 2]))};
	};
	const F3 x = row(0), y = row(1), z = row(2), Px = P * x, Py = P * y, Pz = P * z;
	return {dot(x, Px), dot(y, Py), dot(z, Pz), dot(x, Py), dot(x, Pz), dot(y, Pz)};
}
}  // namespace
