// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "BulletISTCollision/Core/Repair/MeshGround.h"

#include <string>
#include <vector>

namespace ist
{
/// Findings of an inspection of a mesh, after welding equal positions.
struct Closedness
{
	/// True if triangles use every edge equally often in both directions. The winding number is then an integer everywhere off the
	/// surface.
	bool watertight = false;
	int64_t openEdges = 0;         ///< edges with one triangle
	int64_t nonManifoldEdges = 0;  ///< edges with three or more triangles
	int64_t flippedEdges = 0;      ///< edges with two triangles that run through it in the same direction
	int64_t degenerateTriangles = 0;
	int64_t duplicateTriangles = 0;
	int64_t components = 0;  ///< connected sets of triangles
};

enum class RepairMode
{
	Auto,  ///< weld, drop degenerate and duplicate triangles, orient, close holes, settle shells; wrap a surface that cuts itself badly,
		   ///< unless that loses more than it corrects
	Off,    ///< weld exactly equal positions only; refuse a mesh that is not watertight
	Wrap,   ///< rebuild the boundary of the inside on a grid (MeshWrap.h), for any triangles
	Ground  ///< as Auto, but close an open surface downwards to a flat bottom (MeshGround.h) in place of closing its holes
};

/// A mesh that is ready for packing: welded, oriented outwards, closed.
struct RepairedMesh
{
	Mesh mesh;
	Closedness before;
	std::vector<std::string>
		actions;              ///< the mesh's notTaken, then one sentence for each repair that was done; empty if nothing was needed
	double volumeBefore = 0;  ///< signed volume as read [m^3]; for an open mesh, about the middle of its box
	double volumeAfter = 0;
	double volumeDoubt = 0;  ///< estimate of the volume that welding, closed holes (MeshHoles.h) and wrapping may have added or removed
							 ///< [m^3]
	int64_t cuts = 0;        ///< number of pairs of triangles that passed through each other (MeshCuts.h); counted by Auto, up to 1000
};

/// Inspects a mesh. O(n log n).
Closedness inspect(const Mesh& mesh);

/// Repairs a mesh. Errors: the mesh is empty or flat (no volume), or it is open and cannot be closed. The message says what was found and
/// how much of it. Progress stage "repair". The result does not depend on the number of threads. `ground`: used by RepairMode::Ground.
Result<RepairedMesh> repair(
	const Mesh& mesh, RepairMode mode = RepairMode::Auto, const Progress& progress = {}, int threads = 1, const GroundClosing& ground = {});
}  // namespace ist
