// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

/// A zip archive of files that are stored as they are, each a name and its content.
inline std::string zipText(const std::vector<std::pair<std::string, std::string>>& files)
{
	const auto number = [](uint64_t value, size_t size) {
		std::string bytes;
		for (size_t i = 0; i < size; ++i) bytes += static_cast<char>(i < 8 ? value >> 8 * i & 0xff : 0);
		return bytes;
	};
	const auto crc32 = [](const std::string& bytes) {
		uint32_t crc = ~0u;
		for (const char c : bytes)
		{
			crc ^= static_cast<unsigned char>(c);
			for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
		}
		return ~crc;
	};
	std::string bytes, rows;
	for (const auto& [name, content] : files)
	{
		const std::string sizes = number(crc32(content), 4) + number(content.size(), 4) + number(content.size(), 4) +
			number(name.size(), 2) + number(0, 2);
		rows += number(0x02014b50, 4) + number(20, 2) + number(20, 2) + number(0, 8) + sizes + number(0, 10) + number(bytes.size(), 4) +
			name;
		bytes += number(0x04034b50, 4) + number(20, 2) + number(0, 8) + sizes + name + content;
	}
	return bytes + rows + number(0x06054b50, 4) + number(0, 4) + number(files.size(), 2) + number(files.size(), 2) +
		number(rows.size(), 4) + number(bytes.size(), 4) + number(0, 2);
}
