// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Asset/ByteStream.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ist
{
/// Encodes positive floats between two limits as integers below 2^bits. The code counts equal steps of the bit pattern, which grows with
/// the value. The relative size of a step varies by at most a factor of two. Only integers are used, so every machine decodes alike.
class FloatCode
{
public:
	FloatCode() = default;
	FloatCode(float smallest, float largest, int bits) : m_base(bitsOf(smallest))
	{
		while ((uint64_t(bitsOf(largest)) - m_base + (uint64_t(1) << m_shift) / 2) >> m_shift >= uint64_t(1) << bits) ++m_shift;
	}

	/// Values outside the limits are clamped. The decoded value is at most `v`.
	uint32_t roundedDown(float v) const { return (std::max(bitsOf(v), m_base) - m_base) >> m_shift; }
	uint32_t nearest(float v) const
	{
		return static_cast<uint32_t>((uint64_t(std::max(bitsOf(v), m_base)) - m_base + (uint64_t(1) << m_shift) / 2) >> m_shift);
	}
	float decoded(uint32_t code) const
	{
		const uint32_t bits = m_base + (code << m_shift);
		float v;
		std::memcpy(&v, &bits, sizeof v);
		return v;
	}

	void write(ByteWriter& w) const
	{
		w.u32(m_base);
		w.u8(m_shift);
	}
	/// False if some code of this many bits would not decode to a positive finite number.
	bool read(ByteReader& r, int bits)
	{
		m_base = r.u32();
		m_shift = r.u8();
		constexpr uint64_t kInfinity = 0x7f800000;
		return !r.failed() && m_base > 0 && m_shift < 32 && m_base + (((uint64_t(1) << bits) - 1) << m_shift) < kInfinity;
	}

private:
	uint32_t m_base = 1;
	uint8_t m_shift = 0;
};
}  // namespace ist
