// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Vec3.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace ist
{
/// Reads little-endian integers and IEEE numbers at any address, on any machine.
inline uint32_t loadU32(const std::byte* p)
{
	return static_cast<uint32_t>(p[0]) | static_cast<uint32_t>(p[1]) << 8 | static_cast<uint32_t>(p[2]) << 16 |
		static_cast<uint32_t>(p[3]) << 24;
}
inline uint64_t loadU64(const std::byte* p) { return loadU32(p) | static_cast<uint64_t>(loadU32(p + 4)) << 32; }
inline float loadF32(const std::byte* p)
{
	const uint32_t bits = loadU32(p);
	float value;
	std::memcpy(&value, &bits, sizeof value);
	return value;
}
inline uint32_t bitsOf(float value)
{
	uint32_t bits;
	std::memcpy(&bits, &value, sizeof bits);
	return bits;
}

class ByteWriter
{
public:
	void u8(uint8_t v) { m_bytes.push_back(static_cast<std::byte>(v)); }
	/// The low `count` bytes of v.
	void low(uint64_t v, int count)
	{
		for (int i = 0; i < count; ++i) m_bytes.push_back(static_cast<std::byte>(v >> (8 * i)));
	}
	void u16(uint16_t v) { low(v, 2); }
	void u32(uint32_t v) { low(v, 4); }
	void u64(uint64_t v) { low(v, 8); }
	void i64(int64_t v) { u64(static_cast<uint64_t>(v)); }
	void f32(float v) { u32(bitsOf(v)); }
	void f64(double v)
	{
		uint64_t bits;
		std::memcpy(&bits, &v, sizeof bits);
		u64(bits);
	}
	void vec3(const Vec3& v)
	{
		f64(v.x);
		f64(v.y);
		f64(v.z);
	}
	void text(const std::string& s)
	{
		u64(s.size());
		for (char c : s) u8(static_cast<uint8_t>(c));
	}
	void append(const std::byte* bytes, size_t size) { m_bytes.insert(m_bytes.end(), bytes, bytes + size); }
	void append(const std::vector<std::byte>& bytes) { append(bytes.data(), bytes.size()); }
	/// Appends zeros up to the next multiple.
	void align(size_t multiple) { m_bytes.resize((m_bytes.size() + multiple - 1) / multiple * multiple); }
	void reserve(size_t size) { m_bytes.reserve(size); }
	size_t size() const { return m_bytes.size(); }
	const std::vector<std::byte>& bytes() const { return m_bytes; }
	std::vector<std::byte> take() { return std::move(m_bytes); }

private:
	std::vector<std::byte> m_bytes;
};

/// Reader of little-endian values. Reads past the end return zeros and set `failed`.
class ByteReader
{
public:
	ByteReader(const std::byte* bytes, size_t size) : m_bytes(bytes), m_left(size) {}

	uint64_t low(size_t count)
	{
		const std::byte* p = span(count);
		uint64_t v = 0;
		for (size_t i = 0; p && i < count; ++i) v |= static_cast<uint64_t>(p[i]) << (8 * i);
		return v;
	}
	uint8_t u8() { return static_cast<uint8_t>(low(1)); }
	uint16_t u16() { return static_cast<uint16_t>(low(2)); }
	uint32_t u32() { return static_cast<uint32_t>(low(4)); }
	uint64_t u64() { return low(8); }
	int64_t i64() { return static_cast<int64_t>(low(8)); }
	float f32()
	{
		const std::byte* p = span(4);
		return p ? loadF32(p) : 0;
	}
	double f64()
	{
		const uint64_t bits = u64();
		double value;
		std::memcpy(&value, &bits, sizeof value);
		return value;
	}
	Vec3 vec3()
	{
		const double x = f64(), y = f64(), z = f64();
		return {x, y, z};
	}
	/// A number of elements of at least `stride` bytes each. It never exceeds what the remaining bytes can hold.
	size_t count(size_t stride)
	{
		const uint64_t n = u64();
		if (n <= m_left / stride) return static_cast<size_t>(n);
		fail();
		return 0;
	}
	std::string text()
	{
		const size_t n = count(1);
		const std::byte* p = span(n);
		return p ? std::string(reinterpret_cast<const char*>(p), n) : std::string();
	}
	/// The next `size` bytes; null if there are fewer.
	const std::byte* span(size_t size)
	{
		if (size > m_left)
		{
			fail();
			return nullptr;
		}
		const std::byte* p = m_bytes;
		m_bytes += size;
		m_left -= size;
		return p;
	}
	/// Skips to the next address that is a multiple. The skipped bytes must be zeros.
	void align(size_t multiple)
	{
		const size_t gap = (multiple - reinterpret_cast<uintptr_t>(m_bytes) % multiple) % multiple;
		const std::byte* p = span(gap);
		if (p && std::any_of(p, p + gap, [](std::byte b) { return b != std::byte{}; })) fail();
	}
	void fail()
	{
		m_failed = true;
		m_left = 0;
	}
	size_t left() const { return m_left; }
	bool failed() const { return m_failed; }
	bool complete() const { return !m_failed && m_left == 0; }

private:
	const std::byte* m_bytes;
	size_t m_left;
	bool m_failed = false;
};
}  // namespace ist
