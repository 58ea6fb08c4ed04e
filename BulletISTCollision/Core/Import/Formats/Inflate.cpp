// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/Formats/Inflate.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

namespace ist
{
namespace
{
constexpr unsigned kLongestCode = 15, kLiterals = 288, kDistances = 30, kEndOfBlock = 256;

/// Bits of the stream, the lowest of each byte first. Past its end, zeros are returned and `ended()` is true.
class Bits
{
public:
	explicit Bits(std::string_view bytes) : m_bytes(bytes) {}
	/// Returns the next bits, 32 at most, without consuming them.
	unsigned peek(unsigned count)
	{
		for (; m_have < count; m_have += 8, ++m_at)
			if (m_at < m_bytes.size()) m_ahead |= static_cast<uint64_t>(static_cast<unsigned char>(m_bytes[m_at])) << m_have;
		return static_cast<unsigned>(m_ahead & ((uint64_t(1) << count) - 1));
	}
	/// Consumes bits; at most as many as were peeked.
	void drop(unsigned count)
	{
		m_ahead >>= count;
		m_have -= count;
	}
	unsigned take(unsigned count)
	{
		const unsigned value = peek(count);
		drop(count);
		return value;
	}
	/// Consumes whole bytes; empty optional if there are not enough.
	std::optional<std::string_view> takeBytes(size_t count)
	{
		const size_t first = m_at - m_have / 8;
		if (first > m_bytes.size() || m_bytes.size() - first < count) return std::nullopt;
		m_at = first + count;
		m_ahead = 0;
		m_have = 0;
		return m_bytes.substr(first, count);
	}
	bool ended() const { return m_at - m_have / 8 > m_bytes.size(); }

private:
	std::string_view m_bytes;
	size_t m_at = 0;
	uint64_t m_ahead = 0;
	unsigned m_have = 0;
};

/// A prefix code, built from the length of each symbol's code (RFC 1951, 3.2.2).
class PrefixCode
{
public:
	/// False if the lengths describe more codes than fit.
	bool make(std::span<const uint8_t> lengths)
	{
		m_count.fill(0);
		for (const uint8_t length : lengths) ++m_count[length];
		m_count[0] = 0;
		int room = 1;
		std::array<unsigned, kLongestCode + 2> first{};
		for (unsigned length = 1; length <= kLongestCode; ++length)
		{
			room = 2 * room - static_cast<int>(m_count[length]);
			if (room < 0) return false;
			first[length + 1] = first[length] + m_count[length];
		}
		for (unsigned symbol = 0; symbol < lengths.size(); ++symbol)
			if (lengths[symbol]) m_symbols[first[lengths[symbol]]++] = static_cast<uint16_t>(symbol);
		for (unsigned bits = 0; bits < m_short.size(); ++bits) m_short[bits] = find(bits, kShort);
		return true;
	}
	std::optional<unsigned> take(Bits& bits) const
	{
		const unsigned ahead = bits.peek(kLongestCode);
		const Found quick = m_short[ahead & (m_short.size() - 1)], found = quick.length ? quick : find(ahead, kLongestCode);
		bits.drop(found.length);
		if (found.length == 0 || bits.ended()) return std::nullopt;
		return found.symbol;
	}

private:
	static constexpr unsigned kShort = 9;
	struct Found
	{
		uint16_t symbol = 0, length = 0;  // length 0: not found
	};
	Found find(unsigned ahead, unsigned most) const
	{
		unsigned code = 0, first = 0, index = 0;
		for (unsigned length = 1; length <= most; ++length)
		{
			code = 2 * code | (ahead >> (length - 1) & 1);
			if (code < first + m_count[length]) return {m_symbols[index + code - first], static_cast<uint16_t>(length)};
			index += m_count[length];
			first = 2 * (first + m_count[length]);
		}
		return {};
	}

	std::array<unsigned, kLongestCode + 1> m_count{};
	std::array<uint16_t, kLiterals> m_symbols{};
	std::array<Found, 1 << kShort> m_short{};  // table of the short codes, indexed by the bits that begin with them
};

struct BlockCodes
{
	PrefixCode literals, distances;
};

bool makeFixed(BlockCodes& codes)
{
	std::array<uint8_t, kLiterals> lengths;
	std::fill(lengths.begin(), lengths.begin() + 144, uint8_t(8));
	std::fill(lengths.begin() + 144, lengths.begin() + 256, uint8_t(9));
	std::fill(lengths.begin() + 256, lengths.begin() + 280, uint8_t(7));
	std::fill(lengths.begin() + 280, lengths.end(), uint8_t(8));
	std::array<uint8_t, kDistances> equal;
	equal.fill(5);
	return codes.literals.make(lengths) && codes.distances.make(equal);
}

/// Reads the codes that stand in the block itself (RFC 1951, 3.2.7).
bool takeCodes(Bits& bits, BlockCodes& codes)
{
	static constexpr uint8_t kOrder[19] = {16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15};
	const unsigned literals = 257 + bits.take(5), distances = 1 + bits.take(5), given = 4 + bits.take(4);
	if (literals > 286 || distances > kDistances) return false;
	std::array<uint8_t, 19> ofLengths{};
	for (unsigned i = 0; i < given; ++i) ofLengths[kOrder[i]] = static_cast<uint8_t>(bits.take(3));
	PrefixCode lengthCode;
	if (!lengthCode.make(ofLengths)) return false;
	std::array<uint8_t, kLiterals + kDistances> lengths{};
	for (unsigned i = 0; i < literals + distances;)
	{
		const auto symbol = lengthCode.take(bits);
		if (!symbol) return false;
		if (*symbol < 16)
		{
			lengths[i++] = static_cast<uint8_t>(*symbol);
			continue;
		}
		if (*symbol == 16 && i == 0) return false;
		const uint8_t repeated = *symbol == 16 ? lengths[i - 1] : uint8_t(0);
		const unsigned times = *symbol == 16 ? 3 + bits.take(2) : *symbol == 17 ? 3 + bits.take(3) : 11 + bits.take(7);
		if (i + times > literals + distances) return false;
		for (unsigned k = 0; k < times; ++k) lengths[i++] = repeated;
	}
	const std::span<const uint8_t> all(lengths);
	return lengths[kEndOfBlock] && codes.literals.make(all.first(literals)) && codes.distances.make(all.subspan(literals, distances));
}

/// Decodes the symbols of a block, up to its end. False if it is damaged, or gives more than `size` bytes in all.
bool takeSymbols(Bits& bits, const BlockCodes& codes, std::string& out, size_t size)
{
	static constexpr uint16_t kLength[29] = {
		3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 15, 17, 19, 23, 27, 31, 35, 43, 51, 59, 67, 83, 99, 115, 131, 163, 195, 227, 258};
	static constexpr uint8_t kLengthBits[29] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0};
	static constexpr uint16_t kDistance[kDistances] = {1, 2, 3, 4, 5, 7, 9, 13, 17, 25, 33, 49, 65, 97, 129, 193, 257, 385, 513, 769, 1025,
		1537, 2049, 3073, 4097, 6145, 8193, 12289, 16385, 24577};
	for (;;)
	{
		const auto symbol = codes.literals.take(bits);
		if (!symbol) return false;
		if (*symbol == kEndOfBlock) return true;
		if (*symbol < kEndOfBlock)
		{
			if (out.size() == size) return false;
			out.push_back(static_cast<char>(*symbol));
			continue;
		}
		const unsigned row = *symbol - 257;
		if (row >= 29) return false;
		const size_t length = kLength[row] + bits.take(kLengthBits[row]);
		const auto code = codes.distances.take(bits);
		if (!code) return false;
		const size_t distance = kDistance[*code] + bits.take(*code < 2 ? 0 : *code / 2 - 1);
		if (bits.ended() || distance > out.size() || length > size - out.size()) return false;
		for (size_t i = 0; i < length; ++i) out.push_back(out[out.size() - distance]);
	}
}

bool takeStored(Bits& bits, std::string& out, size_t size)
{
	const auto head = bits.takeBytes(4);
	if (!head) return false;
	const auto byte = [&](size_t i) { return static_cast<unsigned>(static_cast<unsigned char>((*head)[i])); };
	const unsigned length = byte(0) | byte(1) << 8, inverse = byte(2) | byte(3) << 8;
	if (length != (~inverse & 0xffff) || length > size - out.size()) return false;
	const auto content = bits.takeBytes(length);
	if (content) out += *content;
	return content.has_value();
}
}  // namespace

std::optional<std::string> inflated(std::string_view stream, size_t size)
{
	// Two bits encode 258 bytes at most.
	constexpr size_t kMostTimes = 1032;
	if (size / kMostTimes > stream.size()) return std::nullopt;
	std::string out;
	out.reserve(size);
	Bits bits(stream);
	for (bool last = false; !last;)
	{
		last = bits.take(1);
		const unsigned kind = bits.take(2);
		if (bits.ended()) return std::nullopt;
		BlockCodes codes;
		const bool taken = kind == 0 ? takeStored(bits, out, size)
			: kind == 1              ? makeFixed(codes) && takeSymbols(bits, codes, out, size)
			: kind == 2              ? takeCodes(bits, codes) && takeSymbols(bits, codes, out, size)
									 : false;
		if (!taken) return std::nullopt;
	}
	if (out.size() != size) return std::nullopt;
	return out;
}
}  // namespace ist
