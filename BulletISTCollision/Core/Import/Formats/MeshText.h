// SPDX-License-Identifier: Zlib
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ist
{
/// The text of a file in UTF-8 without a byte order mark. Reads UTF-8 and UTF-16 in both byte orders, with a byte order mark or, for
/// text that begins with an ASCII letter, without one. Half of a surrogate pair becomes U+FFFD. Text in other encodings stays as it is.
std::string utf8Text(std::string_view bytes);

/// Whether utf8Text() would change the bytes.
bool needsUtf8(std::string_view bytes);

/// The number that a word of a mesh file states: finite, infinite or NaN; a decimal comma is read as a point, and a number that is too
/// small as zero. Empty optional if the word is no number. The result does not depend on the locale.
std::optional<double> numberInText(std::string_view word);

/// A piece of a file for a message: in quotes, at most 40 bytes of it, with "?" for each byte that is not printable ASCII.
std::string quotedText(std::string_view text);
}  // namespace ist
