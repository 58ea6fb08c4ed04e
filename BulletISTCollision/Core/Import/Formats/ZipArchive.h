// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ist
{
/// The files of a zip archive in memory, which must outlive this object. Reads stored and deflated files, also with Zip64 sizes.
class ZipArchive
{
public:
	/// Empty optional if the bytes are no zip archive, or if its table of contents is damaged. The packed files may not be larger together
	/// than the archive: files that share their bytes would take time and memory of the square of its size.
	static std::optional<ZipArchive> open(std::string_view bytes);

	/// File names in the order of the table of contents, with slashes between folders and none in front. Two files may have one name.
	const std::vector<std::string>& names() const { return m_names; }
	/// Content of the first file of a name; empty optional if there is no such file, or if it is damaged (its checksum is compared),
	/// encrypted or packed in another way.
	std::optional<std::string> read(std::string_view name) const;
	/// Content of the file whose name is names()[index].
	std::optional<std::string> read(size_t index) const;

private:
	struct Place
	{
		uint64_t head = 0, packed = 0, size = 0;
		unsigned method = 0;
		uint32_t crc = 0;
		size_t nameSize = 0;
		bool encrypted = false;
	};
	bool agrees(const Place& place) const;

	std::string_view m_bytes;
	std::vector<std::string> m_names;
	std::vector<Place> m_places;
};

/// The form of file names in archives: slashes between folders, none in front.
std::string nameInZip(std::string name);
}  // namespace ist
