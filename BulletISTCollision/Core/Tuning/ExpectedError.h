// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Build/TreeBuilder.h"

namespace ist
{
/// The force error of a tree by its own error bar (PressureField.h): rms over random poses of sigma_F / |F|, the body against itself
/// at an overlap of `fraction` of its volume, k = 1, weights 1/2. An estimate from the tree alone, without the mesh; negative when
/// fewer than half of the poses can overlap that much. Deterministic for a seed; about a millisecond a pose.
double expectedForceError(const InnerSphereTree& tree, double fraction, int poses, uint64_t seed = 1);

/// The smallest of a few trees whose `expectedForceError` at 1 % overlap is at most `error` (0..1): built with more and more spheres,
/// up to `options.maxSpheres`. An error when even that many are too few; the sentence says what was reached.
Result<InnerSphereTree> buildTreeToError(const Mesh& mesh, double error, const BuildOptions& options, BuildTimes* times = nullptr);
}  // namespace ist
