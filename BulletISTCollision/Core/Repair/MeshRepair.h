// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <string>
#include <vector>

namespace ist
{
/// What an inspection of a mesh (after welding equal positions) finds.
struct Closedness
{
	/// Triangles run through every edge as often one way as the other: the winding number is whole everywhere off the surface.
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
	Auto,  ///< weld, drop degenerate and duplicate triangles, orient, close holes, settle shells; wrap where the surface cuts itself badly,
		   ///< unless that loses more than it mends
	Off,  ///< weld exactly equal positions only; refuse a mesh that is not watertight
	Wrap  ///< rebuild the boundary of what lies inside on a grid (MeshWrap.h), whatever the triangles are like
};

/// A mesh fit for packing: welded, oriented outwards, closed.
struct RepairedMesh
{
	Mesh mesh;
	Closedness before;
	std::vector<std::string>
		actions;              ///< the mesh's notTaken, then one sentence for each thing that was done; empty when nothing was needed
	double volumeBefore = 0;  ///< signed volume as read [m^3]; of an open mesh, about the middle of its box
	double volumeAfter = 0;
	double volumeDoubt = 0;  ///< what welding, closed holes (see MeshHoles.h) and wrapping may have added or taken [m^3]; an estimate
	int64_t cuts = 0;        ///< pairs of triangles that passed through each other (see MeshCuts.h); counted by Auto, up to 1000
};

/// O(n log n). The mesh itself is not changed.
Closedness inspect(const Mesh& mesh);

/// Error: empty, flat (no volume), not closed and not closable; the sentence says what was found and how much of it. Stage "repair".
/// The same for any thread count.
Result<RepairedMesh> repair(const Mesh& mesh, RepairMode mode = RepairMode::Auto, const Progress& progress = {}, int threads = 1);
}  // namespace ist
