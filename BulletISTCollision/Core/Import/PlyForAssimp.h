// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"

#include <optional>
#include <string>
#include <string_view>

namespace ist
{
/// The content of a PLY file as assimp 5.2.5 reads it: text in UTF-8 without a byte order mark and without blanks before its first words;
/// binary numbers whose first byte is no blank, because assimp takes blanks there for a part of the header. Empty optional if the content
/// needs no change.
///
/// Error, as the end of a sentence that begins with the path: a binary file has an element before its faces that assimp does not know,
/// and would read as a line of text.
Result<std::optional<std::string>> plyForAssimp(std::string_view bytes);
}  // namespace ist
