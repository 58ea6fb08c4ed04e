// SPDX-License-Identifier: Zlib
#pragma once

#include <filesystem>
#include <string>

namespace ist
{
/// Paths are UTF-8 in all interfaces. A path of the system from one of those, and back. On Windows, characters that are not valid become
/// U+FFFD; elsewhere every byte is kept.
std::filesystem::path systemPath(const std::string& utf8);
std::string utf8Path(const std::filesystem::path& path);
}  // namespace ist
