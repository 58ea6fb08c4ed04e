// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ist
{
/// The files in a zip archive that lies in memory, which must outlive it. Reads stored and deflated files, also with the sizes of Zip64.
class ZipArchive
{
public:
	/// Nothing when the bytes are no zip archive, or its table of contents is damaged.
	static std::optional<ZipArchive> open(std::string_view bytes);

	/// In the order of the table of contents; slashes between folders, none in front.
	const std::vector<std::string>& names() const { return m_names; }
	/// Nothing when there is no such file, or it is damaged, encrypted or packed in another way.
	std::optional<std::string> read(std::string_view name) const;

private:
	struct Place
	{
		uint64_t head = 0, packed = 0, size = 0;
		unsigned method = 0;
		bool encrypted = false;
	};
	std::string_view m_bytes;
	std::vector<std::string> m_names;
	std::vector<Place> m_places;
};

/// How archives name a file: slashes between folders, none in front.
std::string nameInZip(std::string name);
}  // namespace ist
