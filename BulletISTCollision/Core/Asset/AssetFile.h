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
/// Version of `.ist` files that this library reads and writes. Files of other versions are refused, and the error says how to build them
/// again.
constexpr uint32_t kAssetVersion = 7;

/// Encodes little-endian bytes: magic, version, section table, and sections, each with its checksum (XXH64).
std::vector<std::byte> encodeAsset(const InnerSphereTree& tree);
/// Decodes after checking everything: magic, version, sizes, checksums, then every invariant of the trees. It reads archives, too
/// (AssetArchive.h).
Result<InnerSphereTree> decodeAsset(const std::byte* bytes, size_t size);

/// Writes to a temporary file beside `path` and renames it, so that `path` is either the old file or the complete new one. Returns its
/// size. `progress` is called with stage "write".
Result<size_t> saveAsset(const InnerSphereTree& tree, const std::string& path, const Progress& progress = {});
/// Loads a file. Checks every byte, O(balls + elements), but copies none: the tree uses the pages of the file, which all processes share.
/// Replace such a file as `saveAsset` does; overwriting it in place changes the tree while it is in use. An archive is decoded into its own
/// memory.
Result<InnerSphereTree> loadAsset(const std::string& path);
}  // namespace ist
