// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/FloatVector.h"
#include "BulletISTCollision/Core/Query/Kernels/QueryKernel.h"

// Included by QueryKernel.cpp only. Balls are rows in memory and columns in registers. They are loaded and stored in units of sixteen
// bytes and transposed in between.
namespace
{
using namespace ist;
using namespace ist::kernels;

using F = FloatVector<kLanes>;
using D = DoubleVector<kLanes>;
static_assert(F::kParts == 1);
/// A bit for each lane.
constexpr uint32_t kAllLanes = (1u << kLanes) - 1;

// From each sixteen bytes of two registers, these functions take the front or back half of each: two floats, interleaved, or one double.
#if defined(IST_SSE) && defined(__AVX512VL__)
IST_INLINE F::Part frontFloats(F::Part a, F::Part b) { return (F::Part)_mm512_unpacklo_ps((__m512)a, (__m512)b); }
IST_INLINE F::Part backFloats(F::Part a, F::Part b) { return (F::Part)_mm512_unpackhi_ps((__m512)a, (__m512)b); }
IST_INLINE F::Part frontDouble(F::Part a, F::Part b) { return (F::Part)_mm512_unpacklo_pd((__m512d)a, (__m512d)b); }
IST_INLINE F::Part backDouble(F::Part a, F::Part b) { return (F::Part)_mm512_unpackhi_pd((__m512d)a, (__m512d)b); }
#elif defined(IST_SSE) && defined(__AVX2__)
IST_INLINE F::Part frontFloats(F::Part a, F::Part b) { return (F::Part)_mm256_unpacklo_ps((__m256)a, (__m256)b); }
IST_INLINE F::Part backFloats(F::Part a, F::Part b) { return (F::Part)_mm256_unpackhi_ps((__m256)a, (__m256)b); }
IST_INLINE F::Part frontDouble(F::Part a, F::Part b) { return (F::Part)_mm256_unpacklo_pd((__m256d)a, (__m256d)b); }
IST_INLINE F::Part backDouble(F::Part a, F::Part b) { return (F::Part)_mm256_unpackhi_pd((__m256d)a, (__m256d)b); }
#elif defined(IST_NEON)
IST_INLINE F::Part frontFloats(F::Part a, F::Part b) { return (F::Part)vzip1q_f32((float32x4_t)a, (float32x4_t)b); }
IST_INLINE F::Part backFloats(F::Part a, F::Part b) { return (F::Part)vzip2q_f32((float32x4_t)a, (float32x4_t)b); }
IST_INLINE F::Part frontDouble(F::Part a, F::Part b) { return (F::Part)vzip1q_f64((float64x2_t)a, (float64x2_t)b); }
IST_INLINE F::Part backDouble(F::Part a, F::Part b) { return (F::Part)vzip2q_f64((float64x2_t)a, (float64x2_t)b); }
#else
IST_INLINE F::Part frontFloats(F::Part a, F::Part b) { return F::Part{a[0], b[0], a[1], b[1]}; }
IST_INLINE F::Part backFloats(F::Part a, F::Part b) { return F::Part{a[2], b[2], a[3], b[3]}; }
IST_INLINE F::Part frontDouble(F::Part a, F::Part b) { return F::Part{a[0], a[1], b[0], b[1]}; }
IST_INLINE F::Part backDouble(F::Part a, F::Part b) { return F::Part{a[2], a[3], b[2], b[3]}; }
#endif

template <int N> struct Constant
{
	static constexpr int value = N;
};

/// Loads kRows rows of sixteen bytes of each ball, from `place(k) + offset[r]`. For each j below `step`, `to[step * r + j]` receives
/// row r of the balls first + j, first + j + step and so on, side by side.
template <int step, int kRows, class Place>
IST_INLINE void gather(int first, const Place& place, const int (&offset)[kRows], F::Part (&to)[step * kRows])
{
#if defined(IST_SSE) && defined(__AVX512VL__)
	// The loop goes ball by ball, because there are too few registers for all addresses.
	const auto quarter = [&](auto q) __attribute__((always_inline))
	{
		IST_UNROLL
		for (int j = 0; j < step; ++j)
		{
			const char* const ball = place(first + step * decltype(q)::value + j);
			IST_UNROLL
			for (int r = 0; r < kRows; ++r)
			{
				const __m128 row = _mm_loadu_ps(reinterpret_cast<const float*>(ball + offset[r]));
				F::Part& v = to[step * r + j];
				if constexpr (decltype(q)::value == 0) v = (F::Part)_mm512_castps128_ps512(row);
				else v = (F::Part)_mm512_insertf32x4((__m512)v, row, decltype(q)::value);
			}
		}
	};
	quarter(Constant<0>{});
	quarter(Constant<1>{});
	quarter(Constant<2>{});
	quarter(Constant<3>{});
#else
	IST_UNROLL
	for (int r = 0; r < kRows; ++r)
	{
		IST_UNROLL
		for (int j = 0; j < step; ++j)
		{
			const auto row = [&](int k) __attribute__((always_inline))
			{
				return reinterpret_cast<const float*>(place(first + k) + offset[r]);
			};
#if defined(IST_SSE) && defined(__AVX2__)
			to[step * r + j] = (F::Part)_mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(row(j))), _mm_loadu_ps(row(j + step)), 1);
#else
			std::memcpy(&to[step * r + j], row(j), sizeof(F::Part));
#endif
		}
	}
#endif
}

/// Stores sixteen bytes of `v` to each of `at(first)`, `at(first + step)` and so on.
template <int step, class At> IST_INLINE void scatter(F::Part v, int first, const At& at)
{
#if defined(IST_SSE) && defined(__AVX512VL__)
	const __m512 r = (__m512)v;
	_mm_storeu_ps(at(first), _mm512_castps512_ps128(r));
	_mm_storeu_ps(at(first + step), _mm512_extractf32x4_ps(r, 1));
	_mm_storeu_ps(at(first + 2 * step), _mm512_extractf32x4_ps(r, 2));
	_mm_storeu_ps(at(first + 3 * step), _mm512_extractf32x4_ps(r, 3));
#elif defined(IST_SSE) && defined(__AVX2__)
	const __m256 r = (__m256)v;
	_mm_storeu_ps(at(first), _mm256_castps256_ps128(r));
	_mm_storeu_ps(at(first + step), _mm256_extractf128_ps(r, 1));
#else
	std::memcpy(at(first), &v, sizeof v);
#endif
}

/// Transposes rows of four floats to columns, and back. In each four by four block, lane k of register j receives what lane j of
/// register k held.
IST_INLINE void transpose(F::Part& r0, F::Part& r1, F::Part& r2, F::Part& r3)
{
	const F::Part a = frontFloats(r0, r1), b = backFloats(r0, r1), c = frontFloats(r2, r3), d = backFloats(r2, r3);
	r0 = frontDouble(a, c);
	r1 = backDouble(a, c);
	r2 = frontDouble(b, d);
	r3 = backDouble(b, d);
}

#if defined(IST_SSE) && defined(__AVX512VL__)
/// Sorts four registers, each with the four rows of a ball: to[r] receives row r of all four balls.
IST_INLINE void transposeRows(const F::Part (&ball)[4], F::Part (&to)[4])
{
	const auto mixed = [](F::Part a, F::Part b, auto choice) __attribute__((always_inline))
	{
		return (F::Part)_mm512_shuffle_f32x4((__m512)a, (__m512)b, decltype(choice)::value);
	};
	const F::Part front = mixed(ball[0], ball[1], Constant<0x44>{}), back = mixed(ball[0], ball[1], Constant<0xee>{});
	const F::Part front2 = mixed(ball[2], ball[3], Constant<0x44>{}), back2 = mixed(ball[2], ball[3], Constant<0xee>{});
	to[0] = mixed(front, front2, Constant<0x88>{});
	to[1] = mixed(front, front2, Constant<0xdd>{});
	to[2] = mixed(back, back2, Constant<0x88>{});
	to[3] = mixed(back, back2, Constant<0xdd>{});
}
#endif

template <class Ball> IST_INLINE auto placesOf(const Ball* balls, const uint32_t* index)
{
	return [=](int k) __attribute__((always_inline)) { return reinterpret_cast<const char*>(balls + index[k]); };
}

#if defined(IST_SSE) && !defined(__AVX2__)
/// Like placesOf. Arrays of different sizes share one product of each index, which addresses multiply by 2, 4 or 8; GCC would make a
/// product for each array.
template <class Ball> IST_INLINE auto scaledPlacesOf(const Ball* balls, const uint32_t* index)
{
	return [=](int k) __attribute__((always_inline))
	{
		constexpr size_t kUnit = 16, kScale = sizeof(Ball) / kUnit;
		if constexpr (kScale * kUnit != sizeof(Ball) || (kScale & (kScale - 1)) != 0)
			return reinterpret_cast<const char*>(balls + index[k]);
		size_t at = kUnit * index[k];
		asm("" : "+r"(at));
		return reinterpret_cast<const char*>(balls) + kScale * at;
	};
}

/// Eight bytes from each of two addresses, side by side.
IST_INLINE __m128 loadHalves(const char* low, const char* high)
{
	const __m128 front = _mm_castsi128_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(low)));
	return _mm_loadh_pi(front, reinterpret_cast<const __m64*>(high));
}
#endif

/// Loads the rows of four floats that begin `offset[r]` bytes into each ball, as columns: four for each row.
template <int kRows, class Ball>
IST_INLINE void fetchRows(const Ball* balls, const uint32_t* index, const int (&offset)[kRows], F::Part (&columns)[4 * kRows])
{
#if defined(IST_SSE) && !defined(__AVX2__)
	// Loads of halves spare half of the shuffles, each of which would overwrite an operand that must be copied before.
	const auto place = scaledPlacesOf(balls, index);
	const char *const p0 = place(0), *const p1 = place(1), *const p2 = place(2), *const p3 = place(3);
	IST_UNROLL
	for (int i = 0; i < 2 * kRows; ++i)
	{
		const int at = offset[i / 2] + i % 2 * 8;
		const __m128 front = loadHalves(p0 + at, p1 + at), back = loadHalves(p2 + at, p3 + at);
		columns[2 * i] = (F::Part)_mm_shuffle_ps(front, back, 0x88);
		columns[2 * i + 1] = (F::Part)_mm_shuffle_ps(front, back, 0xdd);
	}
	return;
#endif
#if defined(IST_SSE) && defined(__AVX512VL__)
	if constexpr (sizeof(Ball) == sizeof(F::Part))
	{
		// A ball fits one register, so one load replaces a load for each row.
		IST_UNROLL
		for (int j = 0; j < 4; ++j)
		{
			F::Part ball[4], row[4];
			IST_UNROLL
			for (int q = 0; q < 4; ++q) std::memcpy(&ball[q], balls + index[4 * q + j], sizeof(F::Part));
			transposeRows(ball, row);
			IST_UNROLL
			for (int r = 0; r < kRows; ++r) columns[4 * r + j] = row[offset[r] / 16];
		}
	}
	else
#endif
		gather<4, kRows>(0, placesOf(balls, index), offset, columns);
	IST_UNROLL
	for (int r = 0; r < kRows; ++r) transpose(columns[4 * r], columns[4 * r + 1], columns[4 * r + 2], columns[4 * r + 3]);
}

/// Sixteen balls that are contiguous in memory.
struct Block
{
	FloatVector<kBlockWidth> x, y, z, r;
};

IST_INLINE Block fetchBlock(const Sphere* balls)
{
	Block block;
#if defined(IST_SSE) && defined(__AVX512VL__)
	F::Part c[4];
	IST_UNROLL
	for (int i = 0; i < 4; ++i) std::memcpy(&c[i], balls + 4 * i, sizeof(F::Part));
	transpose(c[0], c[1], c[2], c[3]);
	const __m512i order = _mm512_setr_epi32(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
	const auto inOrder = [&](F::Part v) __attribute__((always_inline)) { return (F::Part)_mm512_permutexvar_ps(order, (__m512)v); };
	block = {{inOrder(c[0])}, {inOrder(c[1])}, {inOrder(c[2])}, {inOrder(c[3])}};
#else
	IST_UNROLL
	for (int i = 0; i < kBlockWidth / kLanes; ++i)
	{
		constexpr int offset[1] = {0};
		F::Part c[4];
		gather<4, 1>(
			i * kLanes, [=](int k) __attribute__((always_inline)) { return reinterpret_cast<const char*>(balls + k); }, offset, c);
		transpose(c[0], c[1], c[2], c[3]);
		block.x.part[i] = c[0];
		block.y.part[i] = c[1];
		block.z.part[i] = c[2];
		block.r.part[i] = c[3];
	}
#endif
	return block;
}

/// Stores a row of four floats, from lane k of the columns, into ball k from `balls` on.
IST_INLINE void storeRow(MomentEllipsoid* balls, int offset, F c0, F c1, F c2, F c3)
{
	const auto row = [&](int k) __attribute__((always_inline)) { return reinterpret_cast<float*>(balls + k) + offset; };
	transpose(c0.part[0], c1.part[0], c2.part[0], c3.part[0]);
	scatter<4>(c0.part[0], 0, row);
	scatter<4>(c1.part[0], 1, row);
	scatter<4>(c2.part[0], 2, row);
	scatter<4>(c3.part[0], 3, row);
}

/// Centres and radii of balls in A's tree frame.
struct Centers
{
	D x, y, z, R;
};

IST_INLINE Centers fetchCenters(const MovedCenter* centers, const uint32_t* index)
{
	Centers c;
#if defined(IST_SSE) && !defined(__AVX2__)
	IST_UNROLL
	for (int i = 0; i < D::kParts; ++i)
	{
		const auto place = scaledPlacesOf(centers, index);
		const auto column = [&](int at) __attribute__((always_inline))
		{
			return (D::Part)loadHalves(place(2 * i) + at, place(2 * i + 1) + at);
		};
		c.x.part[i] = column(0);
		c.y.part[i] = column(8);
		c.z.part[i] = column(16);
		c.R.part[i] = column(24);
	}
	return c;
#endif
	constexpr int offset[2] = {0, 16};
	IST_UNROLL
	for (int i = 0; i < D::kParts; ++i)
	{
		F::Part half[4];
		gather<2, 2>(i * D::kRegister, placesOf(centers, index), offset, half);
		c.x.part[i] = (D::Part)frontDouble(half[0], half[1]);
		c.y.part[i] = (D::Part)backDouble(half[0], half[1]);
		c.z.part[i] = (D::Part)frontDouble(half[2], half[3]);
		c.R.part[i] = (D::Part)backDouble(half[2], half[3]);
	}
	return c;
}

/// Stores lane k as ball k.
IST_INLINE void storeCenters(MovedCenter* centers, const Centers& c)
{
	const auto front = [&](int k) __attribute__((always_inline)) { return reinterpret_cast<float*>(centers + k); };
	const auto back = [&](int k) __attribute__((always_inline)) { return reinterpret_cast<float*>(centers + k) + 4; };
	IST_UNROLL
	for (int i = 0; i < D::kParts; ++i)
	{
		const int first = i * D::kRegister;
		const F::Part x = (F::Part)c.x.part[i], y = (F::Part)c.y.part[i], z = (F::Part)c.z.part[i], R = (F::Part)c.R.part[i];
		scatter<2>(frontDouble(x, y), first, front);
		scatter<2>(backDouble(x, y), first + 1, front);
		scatter<2>(frontDouble(z, R), first, back);
		scatter<2>(backDouble(z, R), first + 1, back);
	}
}
}  // namespace
