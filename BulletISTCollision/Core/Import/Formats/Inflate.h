// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace ist
{
/// The decompressed bytes of a DEFLATE stream (RFC 1951). Empty optional if the stream is damaged or does not give exactly `size` bytes.
/// Memory: `size`. A size that no stream of that length can give is refused before allocation.
std::optional<std::string> inflated(std::string_view stream, size_t size);
}  // namespace ist
