// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <cstring>

#if !defined(IST_PORTABLE) && defined(__SSE2__)
#define IST_SSE 1
#include <immintrin.h>
#elif !defined(IST_PORTABLE) && defined(__aarch64__)
#define IST_NEON 1
#include <arm_neon.h>
#endif

// At -O2 the compiler does not unroll loops over the parts, and keeps the vectors in memory.
#if defined(__clang__)
#define IST_UNROLL _Pragma("clang loop unroll(full)")
#else
#define IST_UNROLL _Pragma("GCC unroll 8")
#endif
#define IST_INLINE inline __attribute__((always_inline))

// Only QueryKernel.cpp includes this file, once per instruction set. The anonymous namespace keeps the sets apart.
namespace
{
#if defined(IST_SSE) && defined(__AVX512VL__)
constexpr int kRegisterBytes = 64;
#elif defined(IST_SSE) && defined(__AVX2__)
constexpr int kRegisterBytes = 32;
#else
constexpr int kRegisterBytes = 16;
#endif
/// True if selected lanes of a vector can be moved to its front in a few instructions.
constexpr bool kCompresses = kRegisterBytes > 16;
/// Number of pairs of balls that are evaluated in parallel.
constexpr int kLanes = kRegisterBytes / 4;

constexpr int least(int a, int b) { return a < b ? a : b; }

template <int W> struct FloatPart;
template <> struct FloatPart<4>
{
	typedef float Type __attribute__((vector_size(16)));
	typedef int32_t Mask __attribute__((vector_size(16)));
};
template <> struct FloatPart<8>
{
	typedef float Type __attribute__((vector_size(32)));
	typedef int32_t Mask __attribute__((vector_size(32)));
};
template <> struct FloatPart<16>
{
	typedef float Type __attribute__((vector_size(64)));
	typedef int32_t Mask __attribute__((vector_size(64)));
};
template <int W> struct DoublePart;
template <> struct DoublePart<2>
{
	typedef double Type __attribute__((vector_size(16)));
};
template <> struct DoublePart<4>
{
	typedef double Type __attribute__((vector_size(32)));
};
template <> struct DoublePart<8>
{
	typedef double Type __attribute__((vector_size(64)));
};

/// Number of set bits. Without an instruction for it, GCC calls a function, and everything in registers goes to memory.
IST_INLINE int countBits(uint32_t bits)
{
#if defined(__POPCNT__)
	return __builtin_popcount(bits);
#else
	bits -= bits >> 1 & 0x55555555;
	bits = (bits & 0x33333333) + (bits >> 2 & 0x33333333);
	return int(((bits + (bits >> 4)) & 0x0f0f0f0f) * 0x01010101 >> 24);
#endif
}

/// Number of lanes that are set. `bits`: below 2^kLanes.
IST_INLINE int countLanes(uint32_t bits)
{
	if constexpr (kLanes == 4) return int(0x4332322132212110ull >> (4 * bits) & 7);
	return countBits(bits);
}

/// Bit k is the sign of lane k.
template <class Mask> IST_INLINE uint32_t signBits(Mask m)
{
#if defined(IST_SSE) && defined(__AVX2__)
	if constexpr (sizeof(Mask) == 32)
		return sizeof(m[0]) == 4 ? uint32_t(_mm256_movemask_ps((__m256)m)) : uint32_t(_mm256_movemask_pd((__m256d)m));
#endif
#if defined(IST_SSE)
	if constexpr (sizeof(Mask) == 16)
		return sizeof(m[0]) == 4 ? uint32_t(_mm_movemask_ps((__m128)m)) : uint32_t(_mm_movemask_pd((__m128d)m));
#endif
#if defined(IST_NEON)
	if constexpr (sizeof(Mask) == 16 && sizeof(m[0]) == 4)
	{
		const uint32x4_t bit = {1, 2, 4, 8};
		return vaddvq_u32(vandq_u32(vreinterpretq_u32_s32(vshrq_n_s32((int32x4_t)m, 31)), bit));
	}
#endif
	uint32_t bits = 0;
	for (unsigned k = 0; k < sizeof(Mask) / sizeof(m[0]); ++k) bits |= uint32_t(m[k] < 0) << k;
	return bits;
}

/// Bit k is set if a[k] < b[k].
template <class Part> IST_INLINE uint32_t lessBits(Part a, Part b)
{
#if defined(IST_SSE) && defined(__AVX512VL__)
	constexpr bool kFloats = sizeof(a[0]) == 4;
	if constexpr (sizeof(Part) == 64)
		return kFloats ? uint32_t(_mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LT_OQ))
					   : uint32_t(_mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_LT_OQ));
	if constexpr (sizeof(Part) == 32 && kFloats) return uint32_t(_mm256_cmp_ps_mask((__m256)a, (__m256)b, _CMP_LT_OQ));
#endif
	return signBits(a < b);
}

/// Bit k is set if a[k] == b[k]. For floats only.
template <class Part> IST_INLINE uint32_t equalBits(Part a, Part b)
{
#if defined(IST_SSE) && defined(__AVX512VL__)
	if constexpr (sizeof(Part) == 64) return uint32_t(_mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_EQ_OQ));
#endif
	return signBits(a == b);
}

/// a b + c for floats.
template <class Part> IST_INLINE Part fused(Part a, Part b, Part c)
{
#if defined(IST_SSE) && defined(__AVX512VL__)
	if constexpr (sizeof(Part) == 64) return (Part)_mm512_fmadd_ps((__m512)a, (__m512)b, (__m512)c);
#endif
#if defined(IST_SSE) && defined(__FMA__)
	if constexpr (sizeof(Part) == 32) return (Part)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)c);
#endif
	return a * b + c;
}

/// c - a b for floats.
template <class Part> IST_INLINE Part fusedNegated(Part a, Part b, Part c)
{
#if defined(IST_SSE) && defined(__AVX512VL__)
	if constexpr (sizeof(Part) == 64) return (Part)_mm512_fnmadd_ps((__m512)a, (__m512)b, (__m512)c);
#endif
#if defined(IST_SSE) && defined(__FMA__)
	if constexpr (sizeof(Part) == 32) return (Part)_mm256_fnmadd_ps((__m256)a, (__m256)b, (__m256)c);
#endif
	return c - a * b;
}

template <class Part> IST_INLINE Part rootOf(Part a)
{
#if defined(IST_SSE) && defined(__AVX512VL__)
	if constexpr (sizeof(Part) == 64)
	{
		if constexpr (sizeof(a[0]) == 4) return (Part)_mm512_sqrt_ps((__m512)a);
		else return (Part)_mm512_sqrt_pd((__m512d)a);
	}
#endif
#if defined(IST_SSE) && defined(__AVX2__)
	if constexpr (sizeof(Part) == 32)
	{
		if constexpr (sizeof(a[0]) == 4) return (Part)_mm256_sqrt_ps((__m256)a);
		else return (Part)_mm256_sqrt_pd((__m256d)a);
	}
#endif
#if defined(IST_SSE)
	if constexpr (sizeof(Part) == 16)
	{
		if constexpr (sizeof(a[0]) == 4) return (Part)_mm_sqrt_ps((__m128)a);
		else return (Part)_mm_sqrt_pd((__m128d)a);
	}
#endif
#if defined(IST_NEON)
	if constexpr (sizeof(Part) == 16)
	{
		if constexpr (sizeof(a[0]) == 4) return (Part)vsqrtq_f32((float32x4_t)a);
		else return (Part)vsqrtq_f64((float64x2_t)a);
	}
#endif
	for (unsigned k = 0; k < sizeof(Part) / sizeof(a[0]); ++k)
		a[k] = sizeof(a[0]) == 4 ? __builtin_sqrtf(float(a[k])) : __builtin_sqrt(a[k]);
	return a;
}

/// A boolean for each of `W` floats, in the form in which comparisons give it, so that `select` needs no conversion. With mask registers
/// these are bits; otherwise each lane is all ones or all zeros.
template <int W> struct LaneMask
{
#if defined(IST_SSE) && defined(__AVX512VL__)
	uint32_t lanes;
	static IST_INLINE LaneMask of(uint32_t bits) { return {bits}; }
	IST_INLINE uint32_t bits() const { return lanes; }
	friend IST_INLINE LaneMask operator&(LaneMask a, LaneMask b) { return {a.lanes & b.lanes}; }
	friend IST_INLINE LaneMask operator|(LaneMask a, LaneMask b) { return {a.lanes | b.lanes}; }
	friend IST_INLINE LaneMask operator~(LaneMask a) { return {a.lanes ^ ((1u << W) - 1)}; }
#else
	static constexpr int kRegister = least(W, kRegisterBytes / 4);
	static constexpr int kParts = W / kRegister;
	using Part = typename FloatPart<kRegister>::Mask;
	Part part[kParts];

	static IST_INLINE LaneMask of(uint32_t bits)
	{
		Part lane;
		IST_UNROLL
		for (int k = 0; k < kRegister; ++k) lane[k] = 1 << k;
		LaneMask m;
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) m.part[i] = ((Part{} + int32_t(bits >> (i * kRegister))) & lane) != 0;
		return m;
	}
	IST_INLINE uint32_t bits() const
	{
#if defined(IST_SSE)
		if constexpr (kParts == 4 && sizeof(Part) == 16)
		{
			const __m128i low = _mm_packs_epi32((__m128i)part[0], (__m128i)part[1]);
			const __m128i high = _mm_packs_epi32((__m128i)part[2], (__m128i)part[3]);
			return uint32_t(_mm_movemask_epi8(_mm_packs_epi16(low, high)));
		}
#elif defined(IST_NEON)
		if constexpr (kParts == 4)
		{
			uint32_t bytes[2];
			writeBytes(bytes);
			return bytes[0] | bytes[1] << 8;
		}
		if constexpr (kParts == 2)
		{
			const uint16x8_t bit = {1, 2, 4, 8, 16, 32, 64, 128};
			return vaddvq_u16(vandq_u16(vuzp1q_u16((uint16x8_t)part[0], (uint16x8_t)part[1]), bit));
		}
		if constexpr (kParts == 1)
		{
			const uint32x4_t bit = {1, 2, 4, 8};
			return vaddvq_u32(vandq_u32((uint32x4_t)part[0], bit));
		}
#endif
		uint32_t bits = 0;
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) bits |= signBits(part[i]) << (i * kRegister);
		return bits;
	}
	/// The bits of sixteen lanes, in two bytes.
	IST_INLINE void writeBytes(uint32_t (&bytes)[2]) const
	{
#if defined(IST_NEON)
		// The lanes become bytes, of which each keeps its own bit.
		const uint16x8_t low = vuzp1q_u16((uint16x8_t)part[0], (uint16x8_t)part[1]);
		const uint16x8_t high = vuzp1q_u16((uint16x8_t)part[2], (uint16x8_t)part[3]);
		const uint8x16_t bit = {1, 2, 4, 8, 16, 32, 64, 128, 1, 2, 4, 8, 16, 32, 64, 128};
		const uint8x16_t own = vandq_u8(vuzp1q_u8((uint8x16_t)low, (uint8x16_t)high), bit);
		bytes[0] = vaddv_u8(vget_low_u8(own));
		bytes[1] = vaddv_u8(vget_high_u8(own));
#else
		bytes[0] = bits() & 255;
		bytes[1] = bits() >> 8;
#endif
	}
	friend IST_INLINE LaneMask operator&(LaneMask a, const LaneMask& b)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] &= b.part[i];
		return a;
	}
	friend IST_INLINE LaneMask operator|(LaneMask a, const LaneMask& b)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] |= b.part[i];
		return a;
	}
	friend IST_INLINE LaneMask operator~(LaneMask a)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] = ~a.part[i];
		return a;
	}
#endif
};

/// `W` floats, made of the widest registers that fit.
template <int W> struct FloatVector
{
	static constexpr int kRegister = least(W, kRegisterBytes / 4);
	static constexpr int kParts = W / kRegister;
	using Part = typename FloatPart<kRegister>::Type;
	using Mask = typename FloatPart<kRegister>::Mask;
	using Lanes = LaneMask<W>;
	Part part[kParts];

	// The parts are copied one by one. GCC copies several at once through memory, and the load after that copy stalls.
	static IST_INLINE FloatVector load(const float* p)
	{
		FloatVector v;
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) std::memcpy(&v.part[i], p + i * kRegister, sizeof(Part));
		return v;
	}
	/// Like load, from an address that is a multiple of a register's size: instructions of SSE take their operand from there only.
	static IST_INLINE FloatVector loadAligned(const float* p)
	{
		return load(static_cast<const float*>(__builtin_assume_aligned(p, sizeof(Part))));
	}
	IST_INLINE void store(float* p) const
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) std::memcpy(p + i * kRegister, &part[i], sizeof(Part));
	}
	/// s - 0 equals s for every s, so the compiler drops the subtraction; 0 + s does not (for s = -0).
	static IST_INLINE FloatVector all(float s)
	{
		FloatVector v;
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) v.part[i] = s - Part{};
		return v;
	}

	friend IST_INLINE FloatVector operator+(FloatVector a, const FloatVector& b)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] += b.part[i];
		return a;
	}
	friend IST_INLINE FloatVector operator-(FloatVector a, const FloatVector& b)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] -= b.part[i];
		return a;
	}
	friend IST_INLINE FloatVector operator*(FloatVector a, const FloatVector& b)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] *= b.part[i];
		return a;
	}
	friend IST_INLINE FloatVector operator/(FloatVector a, const FloatVector& b)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] /= b.part[i];
		return a;
	}
	friend IST_INLINE FloatVector operator-(const FloatVector& a) { return all(0) - a; }
	/// a b + c, rounded once if the machine has fused instructions. Not for results that must agree on all machines.
	friend IST_INLINE FloatVector multiplyAdd(FloatVector a, const FloatVector& b, const FloatVector& c)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] = fused(a.part[i], b.part[i], c.part[i]);
		return a;
	}
	/// c - a b, rounded like multiplyAdd.
	friend IST_INLINE FloatVector negatedMultiplyAdd(FloatVector a, const FloatVector& b, const FloatVector& c)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] = fusedNegated(a.part[i], b.part[i], c.part[i]);
		return a;
	}
	IST_INLINE FloatVector& operator+=(const FloatVector& b) { return *this = *this + b; }

	static IST_INLINE FloatVector smaller(FloatVector a, const FloatVector& b)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] = a.part[i] < b.part[i] ? a.part[i] : b.part[i];
		return a;
	}
	static IST_INLINE FloatVector larger(FloatVector a, const FloatVector& b)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] = a.part[i] > b.part[i] ? a.part[i] : b.part[i];
		return a;
	}
	static IST_INLINE FloatVector squareRoot(FloatVector a)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] = rootOf(a.part[i]);
		return a;
	}
	/// Largest power of two that does not exceed a; for normal a > 0.
	static IST_INLINE FloatVector powerOfTwoBelow(FloatVector a)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] = (Part)((Mask)a.part[i] & 0x7f800000);
		return a;
	}
	static IST_INLINE FloatVector inverseOfPower(FloatVector a)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] = (Part)(0x7f000000 - (Mask)a.part[i]);
		return a;
	}
	/// Each word holds two floats without their lower halves. These are the upper and the lower one.
	static IST_INLINE FloatVector upperHalf(FloatVector a)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] = (Part)((Mask)a.part[i] & int32_t(0xffff0000));
		return a;
	}
	static IST_INLINE FloatVector lowerHalf(FloatVector a)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] = (Part)((Mask)a.part[i] << 16);
		return a;
	}
	/// Each word holds two signed 16-bit integers. These are the upper and the lower one, times 65536.
	static IST_INLINE FloatVector upperNumber(FloatVector a)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] = __builtin_convertvector((Mask)a.part[i] & int32_t(0xffff0000), Part);
		return a;
	}
	static IST_INLINE FloatVector lowerNumber(FloatVector a)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] = __builtin_convertvector((Mask)a.part[i] << 16, Part);
		return a;
	}
	/// Lane k is set if a[k] < b[k].
	static IST_INLINE Lanes isLess(const FloatVector& a, const FloatVector& b)
	{
#if defined(IST_SSE) && defined(__AVX512VL__)
		return Lanes::of(less(a, b));
#else
		Lanes m;
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) m.part[i] = a.part[i] < b.part[i];
		return m;
#endif
	}
	/// Bit k is set if a[k] < b[k].
	static IST_INLINE uint32_t less(const FloatVector& a, const FloatVector& b)
	{
#if defined(IST_SSE) && defined(__AVX512VL__)
		uint32_t bits = 0;
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) bits |= lessBits(a.part[i], b.part[i]) << (i * kRegister);
		return bits;
#else
		return isLess(a, b).bits();
#endif
	}
	/// Bit k is set if a[k] == b[k].
	static IST_INLINE uint32_t equal(const FloatVector& a, const FloatVector& b)
	{
		uint32_t bits = 0;
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) bits |= equalBits(a.part[i], b.part[i]) << (i * kRegister);
		return bits;
	}
	/// Lane k of `a` if it is set in `lanes`, otherwise lane k of `b`.
	static IST_INLINE FloatVector select(const Lanes& lanes, FloatVector a, const FloatVector& b)
	{
#if defined(IST_SSE) && defined(__AVX512VL__)
		static_assert(kRegister == 16);
		IST_UNROLL
		for (int i = 0; i < kParts; ++i)
			a.part[i] = (Part)_mm512_mask_blend_ps(__mmask16(lanes.lanes >> (i * kRegister)), (__m512)b.part[i], (__m512)a.part[i]);
#else
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] = lanes.part[i] ? a.part[i] : b.part[i];
#endif
		return a;
	}
	/// Like select above, with a bit per lane.
	static IST_INLINE FloatVector select(uint32_t bits, const FloatVector& a, const FloatVector& b)
	{
		return select(Lanes::of(bits), a, b);
	}
	IST_INLINE double sum() const
	{
		float lanes[W];
		store(lanes);
		IST_UNROLL
		for (int width = W / 2; width > 0; width /= 2)
		{
			IST_UNROLL
			for (int k = 0; k < width; ++k) lanes[k] += lanes[k + width];
		}
		return lanes[0];
	}
};

/// `W` doubles in two registers, as many as one register holds floats.
template <int W> struct DoubleVector
{
	static constexpr int kRegister = kRegisterBytes / 8;
	static constexpr int kParts = 2;
	static_assert(W == kParts * kRegister);
	using Part = typename DoublePart<kRegister>::Type;
	Part part[kParts];

	static IST_INLINE DoubleVector all(double s)
	{
		DoubleVector v;
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) v.part[i] = s - Part{};
		return v;
	}
	// The conversion stays in registers, because two halves that are joined through memory stall the load.
	static IST_INLINE DoubleVector from(const FloatVector<W>& f)
	{
		DoubleVector v;
#if defined(IST_SSE) && defined(__AVX512VL__)
		v.part[0] = (Part)_mm512_cvtps_pd(_mm512_castps512_ps256((__m512)f.part[0]));
		v.part[1] = (Part)_mm512_cvtps_pd(_mm512_extractf32x8_ps((__m512)f.part[0], 1));
#elif defined(IST_SSE) && defined(__AVX2__)
		v.part[0] = (Part)_mm256_cvtps_pd(_mm256_castps256_ps128((__m256)f.part[0]));
		v.part[1] = (Part)_mm256_cvtps_pd(_mm256_extractf128_ps((__m256)f.part[0], 1));
#elif defined(IST_SSE)
		v.part[0] = (Part)_mm_cvtps_pd((__m128)f.part[0]);
		v.part[1] = (Part)_mm_cvtps_pd(_mm_movehl_ps((__m128)f.part[0], (__m128)f.part[0]));
#elif defined(IST_NEON)
		v.part[0] = (Part)vcvt_f64_f32(vget_low_f32((float32x4_t)f.part[0]));
		v.part[1] = (Part)vcvt_high_f64_f32((float32x4_t)f.part[0]);
#else
		for (int k = 0; k < W; ++k) v.part[k / kRegister][k % kRegister] = f.part[0][k];
#endif
		return v;
	}
	IST_INLINE FloatVector<W> rounded() const
	{
		FloatVector<W> f;
#if defined(IST_SSE) && defined(__AVX512VL__)
		const __m512 low = _mm512_castps256_ps512(_mm512_cvtpd_ps((__m512d)part[0]));
		f.part[0] = (typename FloatVector<W>::Part)_mm512_insertf32x8(low, _mm512_cvtpd_ps((__m512d)part[1]), 1);
#elif defined(IST_SSE) && defined(__AVX2__)
		const __m256 low = _mm256_castps128_ps256(_mm256_cvtpd_ps((__m256d)part[0]));
		f.part[0] = (typename FloatVector<W>::Part)_mm256_insertf128_ps(low, _mm256_cvtpd_ps((__m256d)part[1]), 1);
#elif defined(IST_SSE)
		f.part[0] = (typename FloatVector<W>::Part)_mm_movelh_ps(_mm_cvtpd_ps((__m128d)part[0]), _mm_cvtpd_ps((__m128d)part[1]));
#elif defined(IST_NEON)
		f.part[0] = (typename FloatVector<W>::Part)vcvt_high_f32_f64(vcvt_f32_f64((float64x2_t)part[0]), (float64x2_t)part[1]);
#else
		for (int k = 0; k < W; ++k) f.part[0][k] = float(part[k / kRegister][k % kRegister]);
#endif
		return f;
	}
	friend IST_INLINE DoubleVector operator+(DoubleVector a, const DoubleVector& b)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] += b.part[i];
		return a;
	}
	friend IST_INLINE DoubleVector operator-(DoubleVector a, const DoubleVector& b)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] -= b.part[i];
		return a;
	}
	friend IST_INLINE DoubleVector operator*(DoubleVector a, const DoubleVector& b)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] *= b.part[i];
		return a;
	}
	static IST_INLINE DoubleVector squareRoot(DoubleVector a)
	{
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) a.part[i] = rootOf(a.part[i]);
		return a;
	}
	/// Lane k is set if a[k] < b[k].
	static IST_INLINE LaneMask<W> isLess(const DoubleVector& a, const DoubleVector& b)
	{
#if defined(IST_SSE) && defined(__AVX2__) && !defined(__AVX512VL__)
		const __m256 even = _mm256_shuffle_ps((__m256)(a.part[0] < b.part[0]), (__m256)(a.part[1] < b.part[1]), 0x88);
		return {(typename LaneMask<W>::Part)_mm256_permute4x64_pd((__m256d)even, 0xd8)};
#elif defined(IST_SSE) && !defined(__AVX512VL__)
		return {(typename LaneMask<W>::Part)_mm_shuffle_ps((__m128)(a.part[0] < b.part[0]), (__m128)(a.part[1] < b.part[1]), 0x88)};
#elif defined(IST_NEON)
		return {(typename LaneMask<W>::Part)vuzp1q_s32((int32x4_t)(a.part[0] < b.part[0]), (int32x4_t)(a.part[1] < b.part[1]))};
#else
		uint32_t bits = 0;
		IST_UNROLL
		for (int i = 0; i < kParts; ++i) bits |= lessBits(a.part[i], b.part[i]) << (i * kRegister);
		return LaneMask<W>::of(bits);
#endif
	}
};
}  // namespace
