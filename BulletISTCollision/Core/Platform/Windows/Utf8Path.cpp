// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/Utf8Path.h"

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

namespace ist
{
std::filesystem::path systemPath(const std::string& utf8) { return wide(utf8); }
std::string utf8Path(const std::filesystem::path& path) { return narrow(path.native()); }
}  // namespace ist
