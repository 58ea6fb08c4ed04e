// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

#include <cstddef>
#include <string>
#include <vector>

namespace ist
{
/// `.ist` version this library writes. Older versions that were released stay readable.
constexpr uint32_t kAssetVersion = 6;

/// Little-endian bytes: magic, version, section table, sections, each with its checksum (XXH64).
std::vector<std::byte> encodeAsset(const InnerSphereTree& tree);
/// Everything is checked before it is believed: magic, version, sizes, checksums, then every invariant of the trees. Reads
/// archives too (AssetArchive.h).
Result<InnerSphereTree> decodeAsset(const std::byte* bytes, size_t size);

/// Writes to a temporary file beside `path` and renames it, so that `path` is either the old file or the whole new one.
/// Gives its size. `progress` is called with stage "write".
Result<size_t> saveAsset(const InnerSphereTree& tree, const std::string& path, const Progress& progress = {});
/// Checks every byte, O(balls), but copies none: the tree uses the pages of the file, which all processes share. Replace such a file as
/// `saveAsset` does; who overwrites it in place changes the tree under its user. An archive is decoded into memory of its own.
Result<InnerSphereTree> loadAsset(const std::string& path);
}  // namespace ist
