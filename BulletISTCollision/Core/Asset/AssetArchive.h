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
/// An `.ista` file stores rounded spheres and leaves, about 40 bytes per sphere, and the body's surface as it is, about 220 bytes for an
/// element and a cell. Cells and trees are rebuilt when it is read, in about 2 us per sphere. Centres lie on a grid of 2^21 steps per side.
/// Each stored sphere lies inside its original, so that no two overlap and none protrudes, with the same bits on every machine. Leaves keep
/// their volume to 0.5 % each, their mean radius to 0.1 %, shapes to 1.3 % of the mean square radius, positions to 1/16000 of the largest
/// offset from a sphere, and normals to 1/1000. The mean radius of thin ellipsoids is kept only to a tenth: those shorter than a tenth of
/// their length, or with less than 0.4 of their leaf's volume.
constexpr uint32_t kArchiveVersion = 2;

/// Error: a sphere is too small relative to the body.
Result<std::vector<std::byte>> encodeArchive(const InnerSphereTree& tree);
Result<InnerSphereTree> decodeArchive(const std::byte* bytes, size_t size);
/// Decides by the first bytes alone.
bool isArchive(const std::byte* bytes, size_t size);

/// Returns the size of the file. Like `saveAsset`, it writes the whole file or none.
Result<size_t> saveArchive(const InnerSphereTree& tree, const std::string& path, const Progress& progress = {});
}  // namespace ist
