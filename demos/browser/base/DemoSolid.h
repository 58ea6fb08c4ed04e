// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/BrowsableDemo.h"
#include "demos/browser/drawing/PackedSpheres.h"

#include <memory>
#include <optional>

namespace browser
{
/// A closed mesh in its principal frame, which is Bullet's frame of the body, with its tree and what is drawn of it. Immutable.
struct DemoSolid
{
	std::string name;
	ist::Mesh mesh;
	std::shared_ptr<const ist::InnerSphereTree> tree;
	std::shared_ptr<const SurfaceModel> surface;
	PackedSpheres spheres;
	ist::Pose X_MP;  ///< of the principal frame in that of the mesh as given
};
using SolidPtr = std::shared_ptr<const DemoSolid>;

/// Into `solid`, which stays what it was where that fails. `spheres`: packed, unless the options say how many. `turned`: false leaves the
/// axes as they are and only puts the centre of mass at the origin, for meshes whose axes are principal already.
std::optional<ist::Error> makeSolid(
	SolidPtr& solid, const std::string& name, const ist::Mesh& mesh, long long spheres, const DemoOptions& options, bool turned = false);

/// The mesh that the options name, scaled so that its longest side is `size` [m] and upright as it is; `otherwise` when they name none.
ist::Result<ist::Mesh> chosenMesh(const DemoOptions& options, double size, const ist::Mesh& otherwise);

/// A stand-in for any user's mesh: a torus knot, longest side `size` [m], lying flat.
ist::Mesh knotMesh(double size);
}  // namespace browser
