// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/FloatVector.h"

// Included by QueryKernel.cpp only. One ball against several.
namespace
{
/// A ball whose numbers stand in all lanes.
template <int W> struct BallLanes
{
	FloatVector<W> x, y, z, r;

	/// `p`: centre and radius.
	static IST_INLINE BallLanes of(const float* p)
	{
		using V = FloatVector<W>;
#if defined(IST_SSE) && !defined(__AVX2__)
		const __m128 row = _mm_loadu_ps(p);
		BallLanes b;
		IST_UNROLL
		for (int i = 0; i < V::kParts; ++i)
		{
			b.x.part[i] = (typename V::Part)_mm_shuffle_ps(row, row, 0x00);
			b.y.part[i] = (typename V::Part)_mm_shuffle_ps(row, row, 0x55);
			b.z.part[i] = (typename V::Part)_mm_shuffle_ps(row, row, 0xaa);
			b.r.part[i] = (typename V::Part)_mm_shuffle_ps(row, row, 0xff);
		}
		return b;
#elif defined(IST_NEON)
		const float32x4_t row = vld1q_f32(p);
		BallLanes b;
		IST_UNROLL
		for (int i = 0; i < V::kParts; ++i)
		{
			b.x.part[i] = (typename V::Part)vdupq_laneq_f32(row, 0);
			b.y.part[i] = (typename V::Part)vdupq_laneq_f32(row, 1);
			b.z.part[i] = (typename V::Part)vdupq_laneq_f32(row, 2);
			b.r.part[i] = (typename V::Part)vdupq_laneq_f32(row, 3);
		}
		return b;
#else
		return {V::all(p[0]), V::all(p[1]), V::all(p[2]), V::all(p[3])};
#endif
	}
};

/// Lane k is set if sphere k of the arrays intersects the ball.
template <int W>
IST_INLINE LaneMask<W> touching(
	const FloatVector<W>& x, const FloatVector<W>& y, const FloatVector<W>& z, const FloatVector<W>& r, const BallLanes<W>& ball)
{
	using V = FloatVector<W>;
	// The arrays are subtrahends, because an instruction can take that operand from memory.
	const V dx = ball.x - x, dy = ball.y - y, dz = ball.z - z, sum = ball.r + r;
	return V::isLess(dx * dx + dy * dy + dz * dz, sum * sum);
}

/// Like touching(), but with fused rounding.
template <int W>
IST_INLINE LaneMask<W> nearlyTouching(
	const FloatVector<W>& x, const FloatVector<W>& y, const FloatVector<W>& z, const FloatVector<W>& r, const BallLanes<W>& ball)
{
	using V = FloatVector<W>;
	const V dx = ball.x - x, dy = ball.y - y, dz = ball.z - z, sum = ball.r + r;
	return V::isLess(multiplyAdd(dz, dz, multiplyAdd(dy, dy, dx * dx)), sum * sum);
}
}  // namespace
