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
/// An `.ista` file holds spheres and leaves, rounded, in about 40 bytes a sphere; cells and trees are built again when it is read,
/// about 2 us a sphere. Centres lie on a grid of 2^21 steps a side, and each stored sphere lies inside its original, so that
/// no two overlap and none protrudes, in the same bits on every machine. Leaves keep their volume to .5 % each, their mean radius to .1 %,
/// shapes to 1.3 % of the mean square radius, places to 1/16000 of the largest offset from a sphere, normals to 1/1000. Where an ellipsoid
/// is thin, shorter than a tenth of its length or of less than .4 of its leaf's volume, its mean radius is kept to a tenth only.
constexpr uint32_t kArchiveVersion = 1;

/// Error: a sphere too small beside the body.
Result<std::vector<std::byte>> encodeArchive(const InnerSphereTree& tree);
Result<InnerSphereTree> decodeArchive(const std::byte* bytes, size_t size);
/// By the first bytes alone.
bool isArchive(const std::byte* bytes, size_t size);

/// Gives the size. As `saveAsset`: the whole file or none.
Result<size_t> saveArchive(const InnerSphereTree& tree, const std::string& path, const Progress& progress = {});
}  // namespace ist
