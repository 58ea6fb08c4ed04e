// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

#include <cstdint>

namespace ist
{
/// To be raised when the output of `buildTree` changes: trees that an older one built are then built anew (treeKey).
inline constexpr uint32_t kBuilderVersion = 4;

struct BuildOptions
{
	int64_t maxSpheres = 10000;  ///< the packing stops at the first of these three (PackingOptions)
	double targetFill = 1.0;     ///< 0..1
	double minRadius = 0;        ///< [m]
	RepairMode repair = RepairMode::Auto;
	double unit = 1;  ///< recorded in the asset; the mesh is already in metres
	uint64_t seed = 1;
	int threads = 0;  ///< 0: all
	Progress progress;
};

/// Of a body that is full with fewer spheres than were asked for, as smooth ones are: whether asking for more makes its leaves smaller.
bool leavesBecomeSmaller(const BuildOptions& options);

/// Wall-clock seconds of the stages.
struct BuildTimes
{
	double setup = 0, packing = 0, leaves = 0, tree = 0;
};

/// Mesh to tree, the whole offline chain: repair, packing, cells, trees. The same for any thread count. Errors: those of repair() and
/// packSpheres(), cancelled.
Result<InnerSphereTree> buildTree(const Mesh& mesh, const BuildOptions& options, BuildTimes* times = nullptr);

/// The first stage of `buildTree` alone: repair() in the mode of the options.
Result<RepairedMesh> repairToBuild(const Mesh& mesh, const BuildOptions& options);
/// The other stages of `buildTree`. `repaired` is what repairToBuild() made of `mesh` with the same options.
Result<InnerSphereTree> buildRepaired(
	const Mesh& mesh, const RepairedMesh& repaired, const BuildOptions& options, BuildTimes* times = nullptr);
}  // namespace ist
