// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/FloatVector.h"

// Included by QueryKernel.cpp only.
namespace
{
using Vector8 = FloatVector<8>;

/// Table of the lanes of the set bits, in order, for each mask. The rest of each row is unspecified.
struct LaneTable
{
	uint8_t lane[256][8];
	constexpr LaneTable() : lane()
	{
		for (int bits = 0; bits < 256; ++bits)
			for (int k = 0, n = 0; k < 8; ++k)
				if (bits >> k & 1) lane[bits][n++] = uint8_t(k);
	}
};
[[maybe_unused]] constexpr LaneTable kLaneTable;

/// Moves the lanes of the set bits of eight values to `to`, without gaps. It may write eight values, whatever the bits are.
class Compressor
{
public:
	IST_INLINE explicit Compressor(uint32_t bits) : m_bits(bits)
	{
#if defined(IST_SSE) && defined(__AVX2__) && !defined(__AVX512VL__)
		m_lanes = _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(kLaneTable.lane[bits])));
#endif
	}
	IST_INLINE int count() const { return __builtin_popcount(m_bits); }
	IST_INLINE void move(const uint32_t* from, uint32_t* to) const
	{
#if defined(IST_SSE) && defined(__AVX512VL__)
		_mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
			_mm256_maskz_compress_epi32(__mmask8(m_bits), _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from))));
#elif defined(IST_SSE) && defined(__AVX2__)
		_mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
			_mm256_permutevar8x32_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(from)), m_lanes));
#else
		for (uint32_t b = m_bits; b; b &= b - 1) *to++ = from[__builtin_ctz(b)];
#endif
	}
	IST_INLINE void move(const Vector8& from, float* to) const
	{
#if defined(IST_SSE) && defined(__AVX512VL__)
		_mm256_storeu_ps(to, _mm256_maskz_compress_ps(__mmask8(m_bits), (__m256)from.part[0]));
#elif defined(IST_SSE) && defined(__AVX2__)
		_mm256_storeu_ps(to, _mm256_permutevar8x32_ps((__m256)from.part[0], m_lanes));
#else
		float lanes[8];
		from.store(lanes);
		for (uint32_t b = m_bits; b; b &= b - 1) *to++ = lanes[__builtin_ctz(b)];
#endif
	}
	IST_INLINE void move(const float* from, float* to) const
	{
		if constexpr (kCompresses) move(Vector8::load(from), to);
		else
			for (uint32_t b = m_bits; b; b &= b - 1) *to++ = from[__builtin_ctz(b)];
	}

private:
	uint32_t m_bits;
#if defined(IST_SSE) && defined(__AVX2__) && !defined(__AVX512VL__)
	__m256i m_lanes;
#endif
};

/// Number of lanes that are compressed together.
constexpr int kGroup = least(kLanes, 8);

/// Compressor for all lanes of a vector of pairs; it works in registers where the instruction set allows that. Writes a whole vector,
/// whatever the bits are.
class LaneCompressor
{
public:
	IST_INLINE explicit LaneCompressor(uint32_t bits) : m_bits(bits), m_compressor(bits & ((1u << kGroup) - 1)) {}
	IST_INLINE int count() const { return __builtin_popcount(m_bits); }
	IST_INLINE void move(const FloatVector<kLanes>& from, float* to) const
	{
#if defined(IST_SSE) && defined(__AVX512VL__)
		_mm512_storeu_ps(to, _mm512_maskz_compress_ps(__mmask16(m_bits), (__m512)from.part[0]));
#else
		float lanes[kLanes];  // stays in registers where the instruction set compresses registers
		from.store(lanes);
		m_compressor.move(lanes, to);
#endif
	}
	IST_INLINE void move(const uint32_t* from, uint32_t* to) const
	{
#if defined(IST_SSE) && defined(__AVX512VL__)
		_mm512_storeu_si512(to, _mm512_maskz_compress_epi32(__mmask16(m_bits), _mm512_loadu_si512(from)));
#else
		m_compressor.move(from, to);
#endif
	}

private:
	uint32_t m_bits;
	Compressor m_compressor;  // compresses all lanes where there are at most eight
};
}  // namespace
