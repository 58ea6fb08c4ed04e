// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace scenes
{
/// Writes a file beside its place first, so that nobody meets half of it. False when it cannot be written: then nothing is left.
bool writeTextFile(const std::string& path, const std::string& text);
}  // namespace scenes
