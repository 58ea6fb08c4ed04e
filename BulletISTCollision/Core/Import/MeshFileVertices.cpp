// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/MeshFileVertices.h"

#include "BulletISTCollision/Core/Import/Formats/ObjForAssimp.h"
#include "BulletISTCollision/Core/Import/MeshFileUnit.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Platform/Utf8Path.h"

#include <fstream>
#include <iterator>
#include <utility>

namespace ist
{
Result<std::vector<Vec3>> importVertices(const std::string& path, std::optional<double> unit)
{
	// The import says what is wrong with a file, also with one whose vertices could be read.
	Result<Mesh> mesh = importMesh(path, unit);
	if (!mesh) return mesh.error();
	if (meshFileEnding(path) != ".obj") return std::move(std::move(mesh).value().vertices);
	const Result<MeshFileHead> head = readMeshFileHead(path);
	if (!head) return head.error();
	std::ifstream file(systemPath(path), std::ios::binary);
	std::vector<Vec3> vertices = objVertices(
		head.value().content ? *head.value().content : std::string{std::istreambuf_iterator<char>(file), {}});
	for (Vec3& v : vertices) v = mesh.value().unit * v;
	return vertices;
}
}  // namespace ist
