// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace ist
{
/// The bytes that a DEFLATE stream (RFC 1951) stands for. Nothing when the stream is damaged or does not give exactly `size` bytes.
/// Memory: `size`, which is refused beforehand where no stream of that length can give as much.
std::optional<std::string> inflated(std::string_view stream, size_t size);
}  // namespace ist
