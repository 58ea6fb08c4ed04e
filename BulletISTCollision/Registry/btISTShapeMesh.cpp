// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Registry/btISTShapeMesh.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletCollision/CollisionShapes/btConcaveShape.h"
#include "BulletCollision/CollisionShapes/btConvexHullShape.h"
#include "BulletCollision/CollisionShapes/btConvexTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btMultiSphereShape.h"
#include "BulletCollision/Gimpact/btGImpactShape.h"
#include "LinearMath/btConvexHullComputer.h"

#include <cmath>
#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace
{
/// Collects triangles in any order; equal corners become one vertex.
class Soup : public btTriangleCallback
{
public:
	void processTriangle(btVector3* corners, int, int) override { add(corners); }
	void add(const btVector3* corners) { m_mesh.triangles.push_back({vertex(corners[0]), vertex(corners[1]), vertex(corners[2])}); }
	ist::Mesh take() { return std::move(m_mesh); }

private:
	uint32_t vertex(const btVector3& corner)
	{
		const ist::Vec3 p = toVec3(corner);
		const auto [found, isNew] = m_indices.emplace(std::make_tuple(p.x, p.y, p.z), uint32_t(m_mesh.vertices.size()));
		if (isNew) m_mesh.vertices.push_back(p);
		return found->second;
	}

	ist::Mesh m_mesh;
	std::map<std::tuple<double, double, double>, uint32_t> m_indices;
};

void addPart(const btGImpactMeshShapePart& part, Soup& soup)
{
	part.lockChildShapes();
	const btPrimitiveManagerBase* triangles = part.getPrimitiveManager();
	btPrimitiveTriangle triangle;
	for (int i = 0; i < triangles->get_primitive_count(); ++i)
	{
		triangles->get_primitive_triangle(i, triangle);
		soup.add(triangle.m_vertices);
	}
	part.unlockChildShapes();
}

ist::Result<ist::Mesh> meshOfGImpact(const btGImpactShapeInterface& shape)
{
	Soup soup;
	if (shape.getGImpactShapeType() == CONST_GIMPACT_TRIMESH_SHAPE)
	{
		const auto& mesh = static_cast<const btGImpactMeshShape&>(shape);
		for (int i = 0; i < mesh.getMeshPartCount(); ++i) addPart(*mesh.getMeshPart(i), soup);
	}
	else if (shape.getGImpactShapeType() == CONST_GIMPACT_TRIMESH_SHAPE_PART)
		addPart(static_cast<const btGImpactMeshShapePart&>(shape), soup);
	else
		return ist::Error{"a GImpact compound has no triangles of its own, and its children's contacts live for one call only, which trees "
						  "cannot; use a btCompoundShape"};
	return soup.take();
}

ist::Mesh meshOfConcave(const btConcaveShape& shape)
{
	Soup soup;
	// Larger than any mesh, while its square is still finite in float.
	const btScalar far(1e15);
	shape.processAllTriangles(&soup, btVector3(-far, -far, -far), btVector3(far, far, far));
	return soup.take();
}

ist::Mesh meshOfHull(const std::vector<btVector3>& points)
{
	btConvexHullComputer hull;
	if (!points.empty()) hull.compute(&points[0][0], int(sizeof(btVector3)), int(points.size()), 0, 0);
	ist::Mesh mesh;
	// The original vertices are used, because the hull's own are rounded to a ten-thousandth of the extent.
	for (int i = 0; i < hull.original_vertex_index.size(); ++i)
		mesh.vertices.push_back(toVec3(points[size_t(hull.original_vertex_index[i])]));
	for (int i = 0; i < hull.faces.size(); ++i)
	{
		// Bullet's faces run clockwise seen from outside.
		const btConvexHullComputer::Edge* first = &hull.edges[hull.faces[i]];
		const uint32_t apex = uint32_t(first->getSourceVertex());
		for (const auto* edge = first->getNextEdgeOfFace(); edge->getTargetVertex() != int(apex); edge = edge->getNextEdgeOfFace())
			mesh.triangles.push_back({apex, uint32_t(edge->getSourceVertex()), uint32_t(edge->getTargetVertex())});
	}
	return mesh;
}

std::vector<btVector3> pointsOf(const btConvexHullShape& shape)
{
	std::vector<btVector3> points;
	for (int i = 0; i < shape.getNumPoints(); ++i) points.push_back(shape.getScaledPoint(i));
	return points;
}

std::vector<btVector3> pointsOf(const btConvexTriangleMeshShape& shape)
{
	struct Corners : btInternalTriangleIndexCallback
	{
		std::vector<btVector3> points;
		void internalProcessTriangleIndex(btVector3* triangle, int, int) override { points.insert(points.end(), triangle, triangle + 3); }
	} corners;
	const btScalar far(BT_LARGE_FLOAT);
	shape.getMeshInterface()->InternalProcessAllTriangles(&corners, btVector3(-far, -far, -far), btVector3(far, far, far));
	return std::move(corners.points);
}

/// The corners of 642-point spheres around each sphere. Their hull lies within 0.4 % of a radius of the hull of the spheres.
std::vector<btVector3> pointsOf(const btMultiSphereShape& shape)
{
	const ist::Mesh unit = ist::makeSphereMesh(1, 3);
	std::vector<btVector3> points;
	for (int i = 0; i < shape.getSphereCount(); ++i)
		for (const ist::Vec3& v : unit.vertices)
			points.push_back((shape.getSpherePosition(i) + toBullet(v) * shape.getSphereRadius(i)) * shape.getLocalScaling());
	return points;
}

ist::Result<ist::Mesh> meshOfType(const btCollisionShape& shape)
{
	switch (shape.getShapeType())
	{
	case GIMPACT_SHAPE_PROXYTYPE: return meshOfGImpact(static_cast<const btGImpactShapeInterface&>(shape));
	case TRIANGLE_MESH_SHAPE_PROXYTYPE:
	case SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE:
	case MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE:
	case TERRAIN_SHAPE_PROXYTYPE:
	case FAST_CONCAVE_MESH_PROXYTYPE: return meshOfConcave(static_cast<const btConcaveShape&>(shape));
	case CONVEX_HULL_SHAPE_PROXYTYPE: return meshOfHull(pointsOf(static_cast<const btConvexHullShape&>(shape)));
	case CONVEX_TRIANGLEMESH_SHAPE_PROXYTYPE: return meshOfHull(pointsOf(static_cast<const btConvexTriangleMeshShape&>(shape)));
	case MULTI_SPHERE_SHAPE_PROXYTYPE: return meshOfHull(pointsOf(static_cast<const btMultiSphereShape&>(shape)));
	case COMPOUND_SHAPE_PROXYTYPE: return ist::Error{"a compound has no triangles of its own; attach trees to its children"};
	default:
		return ist::Error{std::string("a shape of the kind ") + shape.getName() +
			" has no triangles; build a tree from a mesh and attach that, or attach none: Bullet's primitives meet trees as they are"};
	}
}
}  // namespace

ist::Result<ist::Mesh> meshOfShape(const btCollisionShape& shape)
{
	ist::Result<ist::Mesh> mesh = meshOfType(shape);
	if (!mesh) return mesh;
	if (mesh.value().triangles.empty()) return ist::Error{"the shape has no triangles"};
	for (const ist::Vec3& p : mesh.value().vertices)
		if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
			return ist::Error{"the shape has a vertex that is not finite"};
	return mesh;
}
