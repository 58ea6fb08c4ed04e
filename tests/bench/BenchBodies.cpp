// SPDX-License-Identifier: Zlib
#include "tests/bench/BenchBodies.h"

#include "BulletISTCollision/Core/MeshImport.h"
#include "BulletISTCollision/Core/MeshRepair.h"

#include <filesystem>

using namespace ist;

namespace bench
{
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
}  // namespace bench
