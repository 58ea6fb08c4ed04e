// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/Utf8Path.h"

namespace ist
{
std::filesystem::path systemPath(const std::string& utf8) { return utf8; }
std::string utf8Path(const std::filesystem::path& path) { return path.native(); }
}  // namespace ist
