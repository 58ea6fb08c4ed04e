// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletCollisionCommon.h>

#include <vector>

/// A mesh as games pass it to Bullet: arrays of scalars and indices, and an interface to them.
class BulletMesh
{
public:
	explicit BulletMesh(const ist::Mesh& mesh) : m_mesh(mesh)
	{
		for (const ist::Vec3& p : mesh.vertices)
			for (double x : {p.x, p.y, p.z}) m_scalars.push_back(btScalar(x));
		for (const auto& triangle : mesh.triangles)
			for (uint32_t corner : triangle) m_indices.push_back(int(corner));
		m_array.addIndexedMesh(indexed());
	}
	BulletMesh(const BulletMesh&) = delete;

	btIndexedMesh indexed() const
	{
		btIndexedMesh part;
		part.m_numTriangles = int(m_mesh.triangles.size());
		part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(m_indices.data());
		part.m_triangleIndexStride = 3 * sizeof(int);
		part.m_numVertices = int(m_mesh.vertices.size());
		part.m_vertexBase = reinterpret_cast<const unsigned char*>(m_scalars.data());
		part.m_vertexStride = 3 * sizeof(btScalar);
		part.m_vertexType = sizeof(btScalar) == 8 ? PHY_DOUBLE : PHY_FLOAT;
		return part;
	}
	btStridingMeshInterface* interface() const { return &m_array; }
	const ist::Mesh& mesh() const { return m_mesh; }
	btScalar* vertex(size_t i) { return &m_scalars[3 * i]; }

private:
	ist::Mesh m_mesh;
	std::vector<btScalar> m_scalars;
	std::vector<int> m_indices;
	mutable btTriangleIndexVertexArray m_array;
};
