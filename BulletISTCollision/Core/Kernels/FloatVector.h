// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

// At -O2 the compiler leaves loops over the parts rolled and the vectors in memory.
#if defined(__clang__)
#define IST_UNROLL _Pragma("clang loop unroll(full)")
#else
#define IST_UNROLL _Pragma("GCC unroll 8")
#endif

namespace ist::kernels
{
/// `W` floats, made of registers of the widest kind that the target offers.
template <int W>
struct FloatVector
{
#if defined(__AVX__)
	static constexpr int kRegister = 8;
#else
	static constexpr int kRegister = 4;
#endif
	static_assert(W % kRegister == 0);
	static constexpr int kParts = W / kRegister;
	typedef float Part __attribute__((vector_size(kRegister * sizeof(float))));

	Part part[kParts];

	static inline FloatVector load(const float* p)
	{
		FloatVector v;
		std::memcpy(&v.part, p, sizeof v.part);
		return v;
	}
	inline void store(float* p) const { std::memcpy(p, &part, sizeof part); }
	static inline FloatVector all(float s)
	{
		FloatVector v;
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) v.part[i] = Part{} + s;
		return v;
	}

	friend inline FloatVector operator+(FloatVector a, const FloatVector& b)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] += b.part[i];
		return a;
	}
	friend inline FloatVector operator-(FloatVector a, const FloatVector& b)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] -= b.part[i];
		return a;
	}
	friend inline FloatVector operator*(FloatVector a, const FloatVector& b)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] *= b.part[i];
		return a;
	}

	/// Bit k set where a[k] < b[k].
	static inline uint32_t less(const FloatVector& a, const FloatVector& b)
	{
		uint32_t bits = 0;
		IST_UNROLL
		for (int i = 0; i < kParts; ++i)
		{
			const auto mask = a.part[i] < b.part[i];
#if defined(__AVX__)
			bits |= uint32_t(_mm256_movemask_ps((__m256)mask)) << (i * kRegister);
#elif defined(__SSE2__)
			bits |= uint32_t(_mm_movemask_ps((__m128)mask)) << (i * kRegister);
#else
			for (int k = 0; k < kRegister; ++k) bits |= uint32_t(mask[k] & 1) << (i * kRegister + k);
#endif
		}
		return bits;
	}
};

/// Bit k set where the sphere k of the arrays comes nearer than `reach` to touching the sphere (cx, cy, cz, r).
template <int W>
inline uint32_t touching(const float* x, const float* y, const float* z, const float* r, float cx, float cy, float cz, float reach)
{
	using V = FloatVector<W>;
	const V dx = V::load(x) - V::all(cx), dy = V::load(y) - V::all(cy), dz = V::load(z) - V::all(cz);
	const V sum = V::load(r) + V::all(reach);
	return V::less(dx * dx + dy * dy + dz * dz, sum * sum);
}
}  // namespace ist::kernels

#undef IST_UNROLL
