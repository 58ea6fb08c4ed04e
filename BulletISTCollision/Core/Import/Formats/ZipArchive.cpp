// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/Formats/ZipArchive.h"

#include "BulletISTCollision/Core/Import/Formats/Inflate.h"

#include <algorithm>
#include <array>

namespace ist
{
namespace
{
constexpr uint32_t kEndMark = 0x06054b50, kEnd64Mark = 0x06064b50, kEnd64PlaceMark = 0x07064b50, kRowMark = 0x02014b50,
				   kFileMark = 0x04034b50;
constexpr size_t kEndSize = 22, kEnd64Size = 56, kEnd64PlaceSize = 20, kRowSize = 46, kFileHead = 30, kLongestComment = 0xffff;
constexpr uint32_t kInZip64 = 0xffffffff;  // the number stands in the extra field instead

/// Little-endian numbers; the caller checks that they lie within `bytes`.
uint64_t numberAt(std::string_view bytes, size_t at, size_t size)
{
	uint64_t value = 0;
	for (size_t i = 0; i < size; ++i) value |= static_cast<uint64_t>(static_cast<unsigned char>(bytes[at + i])) << 8 * i;
	return value;
}

bool fits(std::string_view bytes, uint64_t at, uint64_t size) { return at <= bytes.size() && size <= bytes.size() - at; }

bool isMark(std::string_view bytes, uint64_t at, size_t size, uint32_t mark)
{
	return fits(bytes, at, size) && numberAt(bytes, at, 4) == mark;
}

/// The table of contents. Offsets count from the beginning of the archive, which may have other bytes before it.
struct Contents
{
	uint64_t rows = 0, at = 0, begin = 0;
};

std::optional<Contents> contentsOf(uint64_t rows, uint64_t size, uint64_t at, uint64_t end)
{
	if (size > end || at > end - size) return std::nullopt;
	return Contents{rows, end - size, end - size - at};
}

std::optional<Contents> findContents(std::string_view bytes)
{
	if (bytes.size() < kEndSize) return std::nullopt;
	const size_t lowest = bytes.size() - std::min(bytes.size(), kEndSize + kLongestComment);
	for (size_t end = bytes.size() - kEndSize + 1; end-- > lowest;)
	{
		if (!isMark(bytes, end, kEndSize, kEndMark)) continue;
		if (end >= kEnd64PlaceSize && isMark(bytes, end - kEnd64PlaceSize, kEnd64PlaceSize, kEnd64PlaceMark))
			if (const uint64_t end64 = numberAt(bytes, end - kEnd64PlaceSize + 8, 8); isMark(bytes, end64, kEnd64Size, kEnd64Mark))
				return contentsOf(numberAt(bytes, end64 + 32, 8), numberAt(bytes, end64 + 40, 8), numberAt(bytes, end64 + 48, 8), end64);
		return contentsOf(numberAt(bytes, end + 10, 2), numberAt(bytes, end + 12, 4), numberAt(bytes, end + 16, 4), end);
	}
	return std::nullopt;
}

/// Reads the numbers that do not fit into a row's 32 bits from its extra field, where they stand in this order.
void takeZip64(std::string_view extra, uint64_t& size, uint64_t& packed, uint64_t& head)
{
	for (size_t at = 0; fits(extra, at, 4);)
	{
		const size_t id = numberAt(extra, at, 2), length = numberAt(extra, at + 2, 2);
		at += 4;
		if (!fits(extra, at, length)) return;
		if (id == 1)
		{
			size_t from = at;
			for (uint64_t* number : {&size, &packed, &head})
				if (*number == kInZip64 && from + 8 <= at + length) *number = numberAt(extra, from, 8), from += 8;
		}
		at += length;
	}
}
/// The checksum of zip files: CRC-32, polynomial 0xedb88320.
uint32_t crcOf(std::string_view bytes)
{
	static const std::array<uint32_t, 256> table = [] {
		std::array<uint32_t, 256> rows{};
		for (uint32_t i = 0; i < 256; ++i)
		{
			rows[i] = i;
			for (int bit = 0; bit < 8; ++bit) rows[i] = rows[i] >> 1 ^ (rows[i] & 1 ? 0xedb88320u : 0);
		}
		return rows;
	}();
	uint32_t crc = ~0u;
	for (const char c : bytes) crc = crc >> 8 ^ table[(crc ^ static_cast<unsigned char>(c)) & 0xff];
	return ~crc;
}
}  // namespace

std::string nameInZip(std::string name)
{
	std::replace(name.begin(), name.end(), '\\', '/');
	return name.substr(std::min(name.find_first_not_of("./"), name.size()));
}

std::optional<ZipArchive> ZipArchive::open(std::string_view bytes)
{
	const std::optional<Contents> contents = findContents(bytes);
	if (!contents) return std::nullopt;
	ZipArchive archive;
	archive.m_bytes = bytes;
	uint64_t at = contents->at, packed = 0;
	for (uint64_t row = 0; row < contents->rows; ++row)
	{
		if (!isMark(bytes, at, kRowSize, kRowMark)) return std::nullopt;
		const size_t nameSize = numberAt(bytes, at + 28, 2), extraSize = numberAt(bytes, at + 30, 2),
					 commentSize = numberAt(bytes, at + 32, 2);
		if (!fits(bytes, at + kRowSize, nameSize + extraSize + commentSize)) return std::nullopt;
		Place place{numberAt(bytes, at + 42, 4), numberAt(bytes, at + 20, 4), numberAt(bytes, at + 24, 4),
			unsigned(numberAt(bytes, at + 10, 2)), uint32_t(numberAt(bytes, at + 16, 4)), nameSize, (numberAt(bytes, at + 8, 2) & 1) != 0};
		takeZip64(bytes.substr(at + kRowSize + nameSize, extraSize), place.size, place.packed, place.head);
		if (place.packed > bytes.size() - packed) return std::nullopt;
		packed += place.packed;
		place.head = place.head > bytes.size() ? place.head : place.head + contents->begin;
		archive.m_names.push_back(nameInZip(std::string(bytes.substr(at + kRowSize, nameSize))));
		archive.m_places.push_back(place);
		at += kRowSize + nameSize + extraSize + commentSize;
	}
	return archive;
}

/// Whether the header before the content says what the table of contents says. Other readers refuse the file if it does not.
bool ZipArchive::agrees(const Place& place) const
{
	const auto number = [&](size_t offset, size_t size) { return numberAt(m_bytes, place.head + offset, size); };
	if (number(8, 2) != place.method || number(26, 2) != place.nameSize) return false;
	const bool isKnownLater = (number(6, 2) & 8) != 0;  // checksum and sizes stand behind the content
	const auto isSize = [](uint64_t stated, uint64_t size) { return stated == size || stated == kInZip64; };
	return isKnownLater || (number(14, 4) == place.crc && isSize(number(18, 4), place.packed) && isSize(number(22, 4), place.size));
}

std::optional<std::string> ZipArchive::read(std::string_view name) const
{
	const auto found = std::find(m_names.begin(), m_names.end(), name);
	return found == m_names.end() ? std::nullopt : read(static_cast<size_t>(found - m_names.begin()));
}

std::optional<std::string> ZipArchive::read(size_t index) const
{
	const Place& place = m_places[index];
	if (place.encrypted || !isMark(m_bytes, place.head, kFileHead, kFileMark) || !agrees(place)) return std::nullopt;
	const uint64_t start = place.head + kFileHead + numberAt(m_bytes, place.head + 26, 2) + numberAt(m_bytes, place.head + 28, 2);
	if (!fits(m_bytes, start, place.packed)) return std::nullopt;
	const std::string_view packed = m_bytes.substr(start, place.packed);
	std::optional<std::string> content;
	if (place.method == 0 && place.packed == place.size) content = std::string(packed);
	if (place.method == 8) content = inflated(packed, place.size);
	return content && crcOf(*content) == place.crc ? content : std::nullopt;
}
}  // namespace ist
