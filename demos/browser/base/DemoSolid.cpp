// SPDX-License-Identifier: Zlib
#include "demos/browser/base/DemoSolid.h"

#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"
#include "TestSupport/SceneFiles/AssetCache.h"
#include "TestSupport/SceneFiles/PrincipalMesh.h"
#include "demos/scenes/Bodies/BodiesOnPlane.h"

#include <optional>
#include <utility>

using namespace ist;

namespace browser
{
std::optional<Error> makeSolid(
	SolidPtr& solid, const std::string& name, const Mesh& mesh, long long spheres, const DemoOptions& options, bool turned)
{
	DemoSolid made;
	made.name = name;
	if (turned)
	{
		scenes::PrincipalMesh principal = scenes::inPrincipalFrame(mesh);
		made.mesh = std::move(principal.mesh);
		made.X_MP = principal.X_MP;
	}
	else
	{
		made.X_MP.translation = massProperties(mesh).centerOfMass;
		made.mesh = translated(mesh, -made.X_MP.translation);
	}
	BuildOptions build;
	build.maxSpheres = options.spheres > 0 ? options.spheres : spheres;
	build.progress = options.progress;
	Result<scenes::CachedTree> tree = scenes::treeFromCache(made.mesh, build, options.cache, name, options.say);
	if (!tree) return Error{name + ": " + tree.error().message, tree.error().cancelled};
	made.tree = tree.value().tree;
	made.surface = makeSurfaceModel(made.mesh);
	made.spheres = PackedSpheres(made.tree);
	solid = std::make_shared<const DemoSolid>(std::move(made));
	return std::nullopt;
}

Result<Mesh> chosenMesh(const DemoOptions& options, double size, const Mesh& otherwise)
{
	if (options.mesh.empty()) return otherwise;
	Result<Mesh> read = importMesh(options.mesh, std::nullopt, options.progress);
	if (!read) return read;
	Mesh mesh = turnedUp(std::move(read).value(), options.up);
	const Box box = bounds(mesh);
	if (!(box.longestSide() > 0)) return Error{options.mesh + ": all points of the mesh are in one place"};
	for (Vec3& p : mesh.vertices) p = (size / box.longestSide()) * (p - 0.5 * (box.lower + box.upper));
	Result<RepairedMesh> repaired = repair(mesh, RepairMode::Auto, options.progress);
	if (!repaired) return Error{options.mesh + ": " + repaired.error().message, repaired.error().cancelled};
	if (options.say)
		for (const std::string& action : repaired.value().actions) options.say(action);
	return std::move(repaired).value().mesh;
}

Mesh knotMesh(double size)
{
	Mesh mesh = makeTorusKnotMesh(1, 0.42, 0.3, 2, 3, 160, 20);
	const double scale = size / bounds(mesh).longestSide();
	// The z axis of the mesh becomes the y axis.
	for (Vec3& p : mesh.vertices) p = scale * Vec3{p.x, p.z, -p.y};
	return mesh;
}
}  // namespace browser
