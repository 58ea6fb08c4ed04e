// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/Formats/MeshText.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>

namespace ist
{
namespace
{
constexpr std::string_view kMark8 = "\xef\xbb\xbf", kMark16Little = "\xff\xfe", kMark16Big = "\xfe\xff";
constexpr std::string_view kMark32Little("\xff\xfe\0\0", 4), kMark32Big("\0\0\xfe\xff", 4);
constexpr uint32_t kReplacement = 0xfffd;

enum class Encoding
{
	Utf8,
	Utf8WithMark,
	Utf16Little,
	Utf16Big,
	Utf32Little,
	Utf32Big
};

bool isAsciiText(unsigned char c) { return c >= ' ' && c < 0x7f; }

Encoding encodingOf(std::string_view bytes)
{
	if (bytes.starts_with(kMark8)) return Encoding::Utf8WithMark;
	// Without their marks these are not told from binary files.
	if (bytes.starts_with(kMark32Little)) return Encoding::Utf32Little;
	if (bytes.starts_with(kMark32Big)) return Encoding::Utf32Big;
	if (bytes.starts_with(kMark16Little)) return Encoding::Utf16Little;
	if (bytes.starts_with(kMark16Big)) return Encoding::Utf16Big;
	if (bytes.size() < 4) return Encoding::Utf8;
	const auto at = [&](size_t i) { return static_cast<unsigned char>(bytes[i]); };
	if (isAsciiText(at(0)) && at(1) == 0 && isAsciiText(at(2)) && at(3) == 0) return Encoding::Utf16Little;
	if (at(0) == 0 && isAsciiText(at(1)) && at(2) == 0 && isAsciiText(at(3))) return Encoding::Utf16Big;
	return Encoding::Utf8;
}

void appendUtf8(std::string& out, uint32_t c)
{
	const auto add = [&](uint32_t byte) { out += static_cast<char>(byte); };
	const auto addRest = [&](unsigned shift) { add(0x80 | (c >> shift & 0x3f)); };
	if (c < 0x80) return add(c);
	if (c < 0x800) add(0xc0 | c >> 6);
	else if (c < 0x10000) add(0xe0 | c >> 12), addRest(6);
	else add(0xf0 | c >> 18), addRest(12), addRest(6);
	addRest(0);
}

std::string fromUtf16(std::string_view bytes, bool little)
{
	const auto unit = [&](size_t i) {
		const uint32_t first = static_cast<unsigned char>(bytes[i]), second = static_cast<unsigned char>(bytes[i + 1]);
		return little ? first | second << 8 : first << 8 | second;
	};
	std::string out;
	out.reserve(bytes.size() / 2);
	for (size_t i = 0; i + 1 < bytes.size(); i += 2)
	{
		const uint32_t c = unit(i);
		if (i == 0 && c == 0xfeff) continue;
		if (c < 0xd800 || c > 0xdfff)
		{
			appendUtf8(out, c);
			continue;
		}
		const uint32_t low = c < 0xdc00 && i + 3 < bytes.size() ? unit(i + 2) : 0;
		const bool isPair = low >= 0xdc00 && low <= 0xdfff;
		appendUtf8(out, isPair ? 0x10000 + ((c - 0xd800) << 10) + (low - 0xdc00) : kReplacement);
		if (isPair) i += 2;
	}
	return out;
}

std::string fromUtf32(std::string_view bytes, bool little)
{
	std::string out;
	out.reserve(bytes.size() / 4);
	for (size_t i = 4; i + 3 < bytes.size(); i += 4)
	{
		uint32_t c = 0;
		for (size_t byte = 0; byte < 4; ++byte) c = c << 8 | static_cast<unsigned char>(bytes[i + (little ? 3 - byte : byte)]);
		appendUtf8(out, c < 0xd800 || (c > 0xdfff && c < 0x110000) ? c : kReplacement);
	}
	return out;
}
}  // namespace

std::string utf8Text(std::string_view bytes)
{
	switch (encodingOf(bytes))
	{
	case Encoding::Utf8WithMark: return std::string(bytes.substr(kMark8.size()));
	case Encoding::Utf16Little: return fromUtf16(bytes, true);
	case Encoding::Utf16Big: return fromUtf16(bytes, false);
	case Encoding::Utf32Little: return fromUtf32(bytes, true);
	case Encoding::Utf32Big: return fromUtf32(bytes, false);
	default: return std::string(bytes);
	}
}

bool needsUtf8(std::string_view bytes) { return encodingOf(bytes) != Encoding::Utf8; }

std::optional<double> numberInText(std::string_view word)
{
	constexpr size_t kLongest = 128;
	if (word.starts_with('+')) word.remove_prefix(1);
	if (word.empty() || word.front() == '+' || word.size() > kLongest) return std::nullopt;
	char text[kLongest];
	std::replace_copy(word.begin(), word.end(), text, ',', '.');
	const char* end = text + word.size();
	double value = 0;
	const std::from_chars_result read = std::from_chars(text, end, value);
	if (read.ptr != end || read.ec == std::errc::invalid_argument) return std::nullopt;
	if (read.ec != std::errc::result_out_of_range) return value;
	// A word of kLongest digits is in range without its exponent, so that the sign of the exponent tells small from large.
	const bool isSmall = word.find("e-") != word.npos || word.find("E-") != word.npos;
	const double size = isSmall ? 0 : std::numeric_limits<double>::infinity();
	return word.front() == '-' ? -size : size;
}

std::string quotedText(std::string_view text)
{
	constexpr size_t kLongest = 40;
	std::string quoted(text.substr(0, kLongest));
	std::ranges::replace_if(
		quoted, [](char c) { return c < ' ' || c > '~'; }, '?');
	return '"' + quoted + '"';
}
}  // namespace ist
