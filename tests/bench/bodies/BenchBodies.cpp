// SPDX-License-Identifier: Zlib
#include "tests/bench/bodies/BenchBodies.h"

#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"
#include "TestSupport/SceneFiles/SceneShapes.h"

#include <filesystem>

using namespace ist;

namespace bench
{
namespace
{
Mesh ellipsoidMesh()
{
	Mesh mesh = makeSphereMesh(1, 5);
	for (Vec3& p : mesh.vertices) p = {p.x, 0.8 * p.y, 0.4 * p.z};
	return mesh;
}

/// A body with six blunt horns and hollows between them.
Mesh jackMesh()
{
	Mesh mesh = makeSphereMesh(1, 5);
	for (Vec3& p : mesh.vertices) p = p * (0.4 + 0.6 * (p.x * p.x * p.x * p.x + p.y * p.y * p.y * p.y + p.z * p.z * p.z * p.z));
	return mesh;
}
}  // namespace

Mesh placed(Mesh mesh)
{
	const double unit = 1 / bounds(mesh).longestSide();
	for (Vec3& p : mesh.vertices) p = p * unit + Vec3{0.3, -0.2, 0.5};
	return mesh;
}

Mesh bunnyMesh()
{
	constexpr const char* path = "/usr/share/glmark2/models/bunny.obj";
	if (!std::filesystem::exists(path)) return {};
	Result<Mesh> mesh = importMesh(path);
	if (!mesh) return {};
	Result<RepairedMesh> repaired = repair(mesh.value());
	return repaired ? repaired.value().mesh : Mesh{};
}

Mesh meshNamed(const std::string& name)
{
	if (name == "bunny") return bunnyMesh();
	if (name == "box") return makeBoxMesh({0.5, 0.35, 0.25});
	if (name == "torus") return makeTorusMesh(0.5, 0.2, 144, 72);
	if (name == "knot") return makeTorusKnotMesh(2, 1, 0.45);
	if (name == "jack") return jackMesh();
	if (name == "ellipsoid") return ellipsoidMesh();
	if (name == "plate") return makeBoxMesh({0.5, 0.35, 0.01});
	if (name == "rod") return makeCapsuleMesh(0.03, 0.47);
	if (name == "wire") return makeTorusKnotMesh(2, 1, 0.08);
	if (name == "crown") return scenes::makeCrownMesh();
	if (name == "sword") return scenes::makeSwordMesh();
	return makeSphereMesh(1, 5);
}

std::vector<Vec3> pointsOf(const Mesh& mesh, double spacing)
{
	std::vector<Vec3> points = mesh.vertices;
	for (const auto& t : mesh.triangles)
		for (size_t e = 0; e < 3; ++e)
		{
			const Vec3 a = mesh.vertices[t[e]], b = mesh.vertices[t[(e + 1) % 3]];
			const int parts = int(distance(a, b) / spacing);
			for (int i = 1; i < parts; ++i) points.push_back(a + (b - a) * (double(i) / parts));
		}
	return points;
}

double separation(const SampledSurface& A, const SampledSurface& B, const Pose& X_AB)
{
	const Pose X_BA = inverse(X_AB);
	double least = 1e300;
	for (const Vec3& p : B.points) least = A.surface.closest(X_AB * p, least).distance;
	for (const Vec3& p : A.points) least = B.surface.closest(X_BA * p, least).distance;
	return least;
}
}  // namespace bench
