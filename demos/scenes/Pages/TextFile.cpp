// SPDX-License-Identifier: Zlib
#include "demos/scenes/Pages/TextFile.h"

#include <filesystem>
#include <fstream>

namespace scenes
{
bool writeTextFile(const std::string& path, const std::string& text)
{
	const std::string part = path + ".part";
	std::ofstream file(part, std::ios::binary);
	file << text;
	file.close();
	std::error_code failed;
	if (file.good()) std::filesystem::rename(part, path, failed);
	if (file.good() && !failed) return true;
	std::filesystem::remove(part, failed);
	return false;
}
}  // namespace scenes
