// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace scenes
{
/// Writes a file under a temporary name first, so that no other program can read half of it. Returns false when it cannot be written; it
/// then leaves no file.
bool writeTextFile(const std::string& path, const std::string& text);
}  // namespace scenes
