// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/Kernels/EllipsoidLanes.h"
#include "BulletISTCollision/Core/Query/Kernels/FaceSearch.h"

// Included by QueryKernel.cpp only. Elements of a surface and the depth of a field at points, several side by side. Every set rounds alike:
// no fused operations.
namespace
{
using Int = F::Mask;

IST_INLINE F all(float x) { return F::all(x); }
IST_INLINE F absolute(const F& x) { return F::larger(x, -x); }
IST_INLINE F3 operator-(const F3& a, const F3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

IST_INLINE bool anyNotNegative(Int v) { return signBits(v) != (1u << kLanes) - 1; }
IST_INLINE void store(Int v, uint32_t* to) { std::memcpy(to, &v, sizeof v); }

/// Stores indices that are about to be loaded one by one.
IST_INLINE void storeIndices(Int v, uint32_t (&to)[kLanes])
{
	store(v, to);
	// Without this, GCC takes the indices out of the register one by one, which is slower than loading them.
	asm volatile("" : "+m"(to));
}

IST_INLINE Int gatherInts(const int32_t* table, Int index)
{
#if defined(IST_SSE) && defined(__AVX512VL__)
	return (Int)_mm512_i32gather_epi32((__m512i)index, table, 4);
#elif defined(IST_SSE) && defined(__AVX2__)
	return (Int)_mm256_i32gather_epi32(table, (__m256i)index, 4);
#else
	Int v;
	for (int k = 0; k < kLanes; ++k) v[k] = table[index[k]];
	return v;
#endif
}

/// Rigid motion from the surface's frame to the field's.
IST_INLINE F3 turned(const FaceSearch& s, const F3& v)
{
	const auto row = [&](int i) __attribute__((always_inline))
	{
		return all(s.rotation[3 * i]) * v.x + all(s.rotation[3 * i + 1]) * v.y + all(s.rotation[3 * i + 2]) * v.z;
	};
	return {row(0), row(1), row(2)};
}
IST_INLINE F3 moved(const FaceSearch& s, const F3& v)
{
	return turned(s, v) + F3{all(s.translation[0]), all(s.translation[1]), all(s.translation[2])};
}

/// The smallest part of the partition that holds the voxel of each point. Points beyond the domain take the nearest voxel.
IST_INLINE Int startAt(const FieldTables& s, const F3& x)
{
	const auto voxel = [&](const F& v, int axis) __attribute__((always_inline))
	{
		const F g = (v - all(s.lower[axis])) * all(s.voxelsPerLength[axis]);
		return __builtin_convertvector(F::smaller(F::larger(g, all(0)), all(float(s.size[axis] - 1))).part[0], Int);
	};
	return gatherInts(s.starts, (voxel(x.x, 0) * s.size[1] + voxel(x.y, 1)) * s.size[2] + voxel(x.z, 2));
}

/// Two levels down the partition, where the part is not yet a cell.
IST_INLINE void descend(const FieldTables& s, Int& part, const F3& x)
{
	alignas(64) uint32_t index[kLanes];
	storeIndices(part > 0 ? part : 0, index);
	constexpr int offset[4] = {0, 16, 32, 48};
	F::Part c[16];
	fetchRows<4>(s.planes, index, offset, c);
	const auto above = [&](int p) __attribute__((always_inline))
	{
		return (F{c[4 * p]} * x.x + F{c[4 * p + 1]} * x.y + F{c[4 * p + 2]} * x.z).part[0] > c[4 * p + 3];
	};
	const Int first = above(0), second = above(1), third = above(2);
	const Int next = first ? (third ? (Int)c[15] : (Int)c[14]) : (second ? (Int)c[13] : (Int)c[12]);
	part = part < 0 ? part : next;
}

IST_INLINE Int cellOf(Int part) { return ~part >> 1; }
/// Bit k is set if nothing of the body is in part k.
IST_INLINE uint32_t isOutside(Int part) { return signBits((~part & kOutsideFlag) != 0); }

struct CellLanes
{
	F3 center, gradient;
	F depth, error, radius;
	F6 hessian;
};

IST_INLINE CellLanes fetchCells(const FieldTables& s, Int part)
{
	alignas(64) uint32_t index[kLanes];
	storeIndices(cellOf(part), index);
	static_assert(sizeof(DepthCell) == 60);
	constexpr int offset[4] = {0, 16, 32, 44};
	F::Part c[16];
	fetchRows<4>(s.cells, index, offset, c);
	return {
		{{c[0]}, {c[1]}, {c[2]}}, {{c[4]}, {c[5]}, {c[6]}}, {c[3]}, {c[14]}, {c[15]}, {{c[7]}, {c[8]}, {c[9]}, {c[10]}, {c[11]}, {c[13]}}};
}

struct DepthLanes
{
	F depth, error;
	F3 gradient;
	uint32_t far;      ///< the samples of the cell are too far away: the quadric says nothing
	uint32_t outside;  ///< nothing of the body is there
};

IST_INLINE DepthLanes depthIn(const CellLanes& c, const F3& x)
{
	const F3 y = x - c.center, hy = c.hessian * y;
	const F reach = all(kFarthestRadii) * F::select(F::isLess(all(kLeastErrorOfRadius) * c.radius, c.error), c.radius, all(1e15f));
	const uint32_t far = F::less(reach * reach, dot(y, y));
	return {c.depth + dot(c.gradient + all(0.5f) * hy, y), c.error, c.gradient + hy, far, far};
}

/// Elements in the field's frame, or quarters of elements.
struct ElementLanes
{
	F3 center, e1, e2, normal, unit, normalS, normalT;
	F k11, k12, k22, area, signedArea, error;
	F::Lanes triangle;

	IST_INLINE F pick(float forTriangle, float forParallelogram) const
	{
		return F::select(triangle, all(forTriangle), all(forParallelogram));
	}
};

/// Sets the derivatives of the normal from the dual vectors of e1 and e2.
IST_INLINE void setNormalChange(ElementLanes& e)
{
	const F g11 = dot(e.e1, e.e1), g12 = dot(e.e1, e.e2), g22 = dot(e.e2, e.e2);
	// The bounds keep the numbers finite for triangles that have no area in single precision; these have no curvature.
	const F product = g11 * g22, inverse = all(1) / F::larger(F::larger(product - g12 * g12, all(1e-6f) * product), all(1e-30f));
	const F a11 = inverse * g22, a12 = -(inverse * g12), a22 = inverse * g11;
	const auto combined = [&](const F& k1, const F& k2) __attribute__((always_inline))
	{
		return (k1 * a11 + k2 * a12) * e.e1 + (k1 * a12 + k2 * a22) * e.e2;
	};
	e.normalS = combined(e.k11, e.k12);
	e.normalT = combined(e.k12, e.k22);
}

IST_INLINE ElementLanes fetchElements(const FaceSearch& s, const uint32_t (&index)[kLanes])
{
	static_assert(sizeof(SurfaceElement) == 72);
	constexpr int offset[5] = {0, 16, 32, 48, 56};
	F::Part c[20];
	fetchRows<5>(s.elements, index, offset, c);
	ElementLanes e;
	e.center = moved(s, {{c[0]}, {c[1]}, {c[2]}});
	e.e1 = turned(s, {{c[3]}, {c[4]}, {c[5]}});
	e.e2 = turned(s, {{c[6]}, {c[7]}, {c[8]}});
	e.normal = turned(s, {{c[9]}, {c[10]}, {c[11]}});
	e.k11 = {c[12]};
	e.k12 = {c[13]};
	e.k22 = {c[14]};
	e.area = {c[15]};
	e.error = {c[18]};
	e.triangle = F::Lanes::of(signBits((Int)c[19] != 0));
	e.signedArea = F::select(e.triangle, -e.area, e.area);
	e.unit = (all(1) / F::squareRoot(F::larger(dot(e.normal, e.normal), all(1e-30f)))) * e.normal;
	setNormalChange(e);
	return e;
}

/// Replaces each element by a quarter of it. `right`, `upper`: bit k is set if the quarter is that of larger s or t. A triangle with both
/// becomes the quarter in its middle.
IST_INLINE void takeQuarters(ElementLanes& e, uint32_t right, uint32_t upper)
{
	const F half = all(0.5f), quarter = all(0.25f), least = e.pick(0, -0.5f);
	const F s = F::select(right, half, least), t = F::select(upper, half, least);
	const F side = F::select(F::Lanes::of(right & upper) & e.triangle, -half, half);
	// The mean height of the quarter.
	const F height = F::select(e.triangle, all(0), -(e.k12 * s * t));
	e.center = e.center + s * e.e1 + t * e.e2 + height * e.unit;
	e.e1 = side * (e.e1 - (e.k11 * s + e.k12 * t) * e.unit);
	e.e2 = side * (e.e2 - (e.k12 * s + e.k22 * t) * e.unit);
	e.normal = e.normal + s * e.normalS + t * e.normalT;
	e.normalS = side * e.normalS;
	e.normalT = side * e.normalT;
	e.k11 = quarter * e.k11;
	e.k12 = quarter * e.k12;
	e.k22 = quarter * e.k22;
	e.area = quarter * e.area;
	e.signedArea = quarter * e.signedArea;
}
}  // namespace
