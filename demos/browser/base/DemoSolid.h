// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/BrowsableDemo.h"
#include "demos/browser/drawing/PackedSpheres.h"

#include <memory>
#include <optional>

namespace browser
{
/// A closed mesh in its principal frame (the frame of Bullet's body), with its tree and its drawing data. Immutable.
struct DemoSolid
{
	std::string name;
	ist::Mesh mesh;
	std::shared_ptr<const ist::InnerSphereTree> tree;
	std::shared_ptr<const SurfaceModel> surface;
	PackedSpheres spheres;
	ist::Pose X_MP;  ///< pose of the principal frame in the frame of the given mesh
};
using SolidPtr = std::shared_ptr<const DemoSolid>;

/// Makes `solid`; if that fails, `solid` does not change. `spheres` is the number of packed spheres, unless the options give one. With
/// `turned` = false the axes stay and only the centre of mass becomes the origin. This is for meshes whose axes are principal axes
/// already.
std::optional<ist::Error> makeSolid(
	SolidPtr& solid, const std::string& name, const ist::Mesh& mesh, long long spheres, const DemoOptions& options, bool turned = false);

/// The mesh that the options name, upright and scaled to the longest side `size` [m]; `otherwise` when they name none.
ist::Result<ist::Mesh> chosenMesh(const DemoOptions& options, double size, const ist::Mesh& otherwise);

/// A substitute for any user's mesh: a torus knot with the longest side `size` [m], lying flat.
ist::Mesh knotMesh(double size);
}  // namespace browser
