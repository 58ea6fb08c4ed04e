// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/FloatVector.h"

#include <cstddef>
#include <type_traits>

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

/// Tables of the lanes of the set bits of the lower and of the upper of two bytes, as words, and of the number of set bits.
struct alignas(16) WideLaneTable
{
	uint32_t lane[2][256][8];
	constexpr WideLaneTable() : lane()
	{
		for (uint32_t bits = 0; bits < 256; ++bits)
			for (uint32_t k = 0, n = 0; k < 8; ++k)
			{
				if (!(bits >> k & 1)) continue;
				lane[0][bits][n] = k;
				lane[1][bits][n++] = k + 8;
			}
	}
};
struct CountTable
{
	uint8_t count[256];
	constexpr CountTable() : count()
	{
		for (int bits = 1; bits < 256; ++bits) count[bits] = uint8_t(count[bits >> 1] + (bits & 1));
	}
};
[[maybe_unused]] constexpr WideLaneTable kWideLaneTable;
[[maybe_unused]] constexpr CountTable kCountTable;

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
	IST_INLINE int count() const { return countBits(m_bits); }
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

#if defined(IST_NEON)
/// Table of the bytes of the lanes of the set bits, in order, for each mask of four.
struct alignas(16) ByteTable
{
	uint8_t byte[16][16];
	constexpr ByteTable() : byte()
	{
		for (int bits = 0; bits < 16; ++bits)
			for (int k = 0, n = 0; k < 4; ++k)
				if (bits >> k & 1)
					for (int i = 0; i < 4; ++i) byte[bits][n++] = uint8_t(4 * k + i);
	}
};
constexpr ByteTable kByteTable;

/// Compressor for four values. Writes four, whatever the bits are.
class Compressor4
{
public:
	IST_INLINE explicit Compressor4(uint32_t bits) : m_bytes(vld1q_u8(kByteTable.byte[bits])) {}
	/// The arrays may overlap if `to` is not behind `from`.
	template <class T> IST_INLINE void move(const T* from, T* to) const
	{
		uint8x16_t lanes;
		std::memcpy(&lanes, from, sizeof lanes);
		lanes = vqtbl1q_u8(lanes, m_bytes);
		std::memcpy(to, &lanes, sizeof lanes);
	}

private:
	uint8x16_t m_bytes;
};
#else
/// Table of the number of set bits below each lane, for each mask of four.
struct PlaceTable
{
	uint8_t place[16][4];
	constexpr PlaceTable() : place()
	{
		for (int bits = 0; bits < 16; ++bits)
			for (int k = 1; k < 4; ++k) place[bits][k] = uint8_t(place[bits][k - 1] + (bits >> (k - 1) & 1));
	}
};
[[maybe_unused]] constexpr PlaceTable kPlaceTable;

/// Compressor for four values, without a branch: each goes where it belongs if its bit is set, and the next one overwrites it otherwise.
/// Writes up to four.
class Compressor4
{
public:
	IST_INLINE explicit Compressor4(uint32_t bits)
		: m_1(kPlaceTable.place[bits][1]),
		  m_2(kPlaceTable.place[bits][2]),
		  m_3(kPlaceTable.place[bits][3])
	{}
	/// The arrays may overlap if `to` is not behind `from`.
	template <class T> IST_INLINE void move(const T* from, T* to) const
	{
		const T a = from[0], b = from[1], c = from[2], d = from[3];
		to[0] = a;
		to[m_1] = b;
		to[m_2] = c;
		to[m_3] = d;
	}

private:
	size_t m_1, m_2, m_3;
};
#endif

/// Number of lanes that are compressed together.
constexpr int kGroup = least(kLanes, 8);

/// Compressor for all lanes of a vector of pairs; it works in registers where the instruction set allows that. Writes a whole vector,
/// whatever the bits are.
class LaneCompressor
{
public:
	IST_INLINE explicit LaneCompressor(uint32_t bits) : m_bits(bits), m_compressor(bits & ((1u << kGroup) - 1)) {}
	IST_INLINE int count() const { return countLanes(m_bits); }
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
	// Compresses all lanes where there are at most eight.
	std::conditional_t<kLanes == 4, Compressor4, Compressor> m_compressor;
};
}  // namespace
