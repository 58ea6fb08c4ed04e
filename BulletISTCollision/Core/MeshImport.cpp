// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/MeshImport.h"

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <exception>
#include <utility>

namespace ist
{
namespace
{
bool mirrors(const aiMatrix4x4& m)
{
	return aiMatrix3x3(m).Determinant() < 0;
}

/// Transform in double; assimp's own is single precision.
Vec3 transformedPoint(const aiMatrix4x4& m, const aiVector3D& v)
{
	const double x = v.x, y = v.y, z = v.z;
	return {m.a1 * x + m.a2 * y + m.a3 * z + m.a4, m.b1 * x + m.b2 * y + m.b3 * z + m.b4,
			m.c1 * x + m.c2 * y + m.c3 * z + m.c4};
}

void append(Mesh& out, const aiMesh& part, const aiMatrix4x4& transform, double unit)
{
	const auto base = static_cast<uint32_t>(out.vertices.size());
	for (unsigned i = 0; i < part.mNumVertices; ++i)
		out.vertices.push_back(unit * transformedPoint(transform, part.mVertices[i]));
	const bool mirrored = mirrors(transform);
	for (unsigned i = 0; i < part.mNumFaces; ++i)
	{
		const aiFace& face = part.mFaces[i];
		if (face.mNumIndices != 3) continue;
		uint32_t a = face.mIndices[0], b = face.mIndices[1], c = face.mIndices[2];
		if (a >= part.mNumVertices || b >= part.mNumVertices || c >= part.mNumVertices) continue;
		if (mirrored) std::swap(b, c);
		out.triangles.push_back({base + a, base + b, base + c});
	}
}

Mesh gather(const aiScene& scene, double unit)
{
	Mesh mesh;
	std::vector<std::pair<const aiNode*, aiMatrix4x4>> open{{scene.mRootNode, aiMatrix4x4()}};
	while (!open.empty())
	{
		const auto [node, parentTransform] = open.back();
		open.pop_back();
		const aiMatrix4x4 transform = parentTransform * node->mTransformation;
		for (unsigned i = 0; i < node->mNumMeshes; ++i)
		{
			const aiMesh& part = *scene.mMeshes[node->mMeshes[i]];
			if (part.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) append(mesh, part, transform, unit);
		}
		for (unsigned i = node->mNumChildren; i-- > 0;) open.emplace_back(node->mChildren[i], transform);
	}
	return mesh;
}
}  // namespace

Result<Mesh> importMesh(const std::string& path, double unit)
{
	if (!(unit > 0) || !std::isfinite(unit))
		return Error{"the unit must be a positive number of metres, not " + std::to_string(unit)};
	try
	{
		Assimp::Importer importer;
		const aiScene* scene = importer.ReadFile(path, aiProcess_Triangulate);
		if (!scene || !scene->mRootNode)
			return Error{"cannot read " + path + ": " + importer.GetErrorString() +
						 "; check the path and that the file is a mesh format that assimp knows"};
		Mesh mesh = gather(*scene, unit);
		for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
			if (!isFinite(mesh.vertices[i]))
				return Error{path + ": the coordinates of vertex " + std::to_string(i) +
							 " are not finite; export the mesh again"};
		if (mesh.triangles.empty()) return Error{path + " contains no triangles; export the surface as polygons"};
		return mesh;
	}
	catch (const std::exception& exception)
	{
		return Error{"cannot read " + path + ": " + exception.what() + "; export the mesh again"};
	}
}
}  // namespace ist
