// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

#include <cstdint>

namespace ist
{
/// Raise this when the output of `buildTree` changes. Trees that an older version built are then built anew (treeKey).
inline constexpr uint32_t kBuilderVersion = 9;

struct BuildOptions
{
	/// Largest number of spheres. The packing stops at the first limit that is met: this one, `targetFill` or `minRadius` (PackingOptions).
	int64_t maxSpheres = 10000;
	double targetFill = 1.0;  ///< fill, 0 to 1
	double minRadius = 0;     ///< smallest radius [m]
	RepairMode repair = RepairMode::Auto;
	GroundClosing ground;  ///< for RepairMode::Ground
	double unit = 1;       ///< unit of the source file, recorded in the asset; the mesh itself is already in metres
	uint64_t seed = 1;
	/// Builds the surface, too (InnerSphereTree::surface). Contact of two bodies that have one begins where their meshes touch, and is
	/// right below the gaps between spheres. A shallow query takes several times as long as one of leaves, a deep one less.
	bool surface = true;
	int threads = 0;  ///< number of threads; 0: all
	Progress progress;
};

/// Whether a larger `maxSpheres` makes the leaves smaller even if fewer spheres fill the body, as in smooth bodies.
bool leavesBecomeSmaller(const BuildOptions& options);

/// Wall-clock times of the stages [s].
struct BuildTimes
{
	double setup = 0, packing = 0, leaves = 0, surface = 0, tree = 0;
};

/// Builds a tree from a mesh, the whole offline chain: repair, packing, cells, trees. The result is the same for any thread count.
/// Errors: those of repair() and packSpheres(), and cancelled.
Result<InnerSphereTree> buildTree(const Mesh& mesh, const BuildOptions& options, BuildTimes* times = nullptr);

/// The first stage of `buildTree` alone: repair() in the mode of the options.
Result<RepairedMesh> repairToBuild(const Mesh& mesh, const BuildOptions& options);
/// The other stages of `buildTree`. `repaired`: result of repairToBuild() for `mesh` with the same options.
Result<InnerSphereTree> buildRepaired(
	const Mesh& mesh, const RepairedMesh& repaired, const BuildOptions& options, BuildTimes* times = nullptr);
}  // namespace ist
