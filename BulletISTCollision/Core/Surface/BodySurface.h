// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Surface/ContactSurface.h"
#include "BulletISTCollision/Core/Surface/DepthField.h"
#include "BulletISTCollision/Core/Surface/QueryTables.h"

namespace ist
{
/// What a body needs for contact: the surface on which others press, and the depth below it. Frame: that of the tree.
struct BodySurface
{
	ContactSurface surface;
	DepthField field;
	QueryTables tables = {};  ///< of both; whoever fills `surface` and `field` calls buildQueryTables, once both are valid

	bool empty() const { return surface.nodes.empty(); }
	/// Size of all arrays.
	size_t bytes() const;
	/// Empty if every invariant holds; otherwise the first violation.
	std::string validate() const;
};

struct BodySurfaceOptions
{
	int64_t cells = 1500, elements = 1500;
	/// While the depth errs more than this on the mesh (depthErrorOnSurface), the surface is built with four times as many cells and
	/// elements, at most twice, and only where that helps [m]. 0: never.
	double error = 0;
	uint64_t seed = 1;
	int threads = 0;  ///< number of threads; 0: all processors
	Progress progress;
};

/// Builds the surface and the depth field of a closed mesh.
Result<BodySurface> buildBodySurface(const MeshDistance& mesh, const BodySurfaceOptions& options);

/// Root mean square of the depth on the mesh, where it should be zero, at some thousand random points [m].
double depthErrorOnSurface(const DepthField& field, const Mesh& mesh, uint64_t seed);

/// Adds the depth field and the tables to what buildContactSurface() made of the mesh.
Result<BodySurface> buildBodySurface(const MeshDistance& mesh, Result<ContactSurface> surface, const BodySurfaceOptions& options);
}  // namespace ist
