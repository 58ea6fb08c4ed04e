// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"

#include <cstddef>
#include <optional>
#include <string>

namespace ist
{
/// Writes to a temporary file beside `path`, flushes it to the medium and renames it. So `path` is either the old file or the complete
/// new one, even if the disk fills up or `progress` (stage "write") cancels. A symbolic link is kept and leads to the new content, even
/// if its target did not exist (on Windows only if it did). A replaced file passes on its access rights. A device or a pipe is written in
/// place. Returns the number of bytes.
Result<size_t> writeFileAtomically(const std::string& path, const std::byte* bytes, size_t size, const Progress& progress = {});
/// The error that writeFileAtomically() would return now; null if none can be foreseen. Call it before expensive work whose result is to
/// be written. A disk may still fill up meanwhile. Leaves nothing behind.
std::optional<Error> whyNotWritable(const std::string& path);

/// Whether writeFileAtomically() on one path would replace what it wrote to the other: true for one file under two names. False for
/// devices and pipes.
bool isSameFile(const std::string& path, const std::string& other);
}  // namespace ist
