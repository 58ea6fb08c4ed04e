// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Base/Vec3.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ist
{
/// The text of an OBJ file as assimp 5.2.5 reads it: in UTF-8 without a byte order mark, without blanks before keywords, and without
/// indices of texture coordinates if the file has no texture coordinates. Empty optional if the file's text needs no change.
///
/// Error, as the end of a sentence that begins with the path: a coordinate that is no number, which assimp would read as another number
/// ("-1.#IND" as -1). "nan" and "inf" are numbers here.
Result<std::optional<std::string>> objForAssimp(std::string_view bytes);

/// The positions in the "v" lines of such a text, in their order. A fourth number is a weight that the others are divided by; six are a
/// position and a colour.
std::vector<Vec3> objVertices(std::string_view text);
}  // namespace ist
