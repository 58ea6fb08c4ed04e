// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Build/TreeBuilder.h"

namespace ist
{
/// Expected force error of a tree from its own error bar (PressureField.h). It is the rms over random poses of sigma_F / |F|, for the
/// body against itself at an overlap of `fraction` of its volume, with k = 1 and weights 1/2. The estimate needs the tree only, not the
/// mesh. Negative if fewer than half of the poses can overlap that much. Deterministic for a seed; about a millisecond per pose.
double expectedForceError(const InnerSphereTree& tree, double fraction, int poses, uint64_t seed = 1);

/// Builds trees with increasing numbers of spheres, up to `options.maxSpheres`, until `expectedForceError` at 1 % overlap is at most
/// `error` (0..1), and returns that tree. If even the largest number is not enough, the error message says what was reached.
Result<InnerSphereTree> buildTreeToError(const Mesh& mesh, double error, const BuildOptions& options, BuildTimes* times = nullptr);
/// The stages of `buildTreeToError` behind the repair. `repaired`: result of repairToBuild() for `mesh` with the same options.
Result<InnerSphereTree> buildRepairedToError(
	const Mesh& mesh, const RepairedMesh& repaired, double error, const BuildOptions& options, BuildTimes* times = nullptr);
}  // namespace ist
