// SPDX-License-Identifier: Zlib
#include "demos/browser/base/StockShape.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btConvexHullShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "BulletCollision/Gimpact/btGImpactShape.h"

using namespace ist;

namespace browser
{
namespace
{
constexpr double kMargin = 1e-3;  // share of the longest side

btScalar marginOf(const Mesh& mesh) { return btScalar(kMargin * bounds(mesh).longestSide()); }
}  // namespace

bool isConvex(const Mesh& mesh)
{
	const double most = 1e-6 * bounds(mesh).longestSide();
	for (const auto& [a, b, c] : mesh.triangles)
	{
		const Vec3 normal = normalized(cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]));
		for (const Vec3& p : mesh.vertices)
			if (dot(normal, p - mesh.vertices[a]) > most) return false;
	}
	return true;
}

std::unique_ptr<btCollisionShape> makeHull(const Mesh& mesh)
{
	auto hull = std::make_unique<btConvexHullShape>();
	for (const Vec3& p : mesh.vertices) hull->addPoint(toBullet(p), false);
	hull->setMargin(marginOf(mesh));
	hull->recalcLocalAabb();
	return hull;
}

StockShape makeStockShape(const Mesh& mesh, bool fixed)
{
	if (isConvex(mesh)) return {nullptr, makeHull(mesh)};
	auto triangles = std::make_unique<btTriangleMesh>();
	for (const Vec3& p : mesh.vertices) triangles->findOrAddVertex(toBullet(p), false);
	for (const auto& [a, b, c] : mesh.triangles) triangles->addTriangleIndices(int(a), int(b), int(c));
	std::unique_ptr<btCollisionShape> shape;
	if (fixed) shape = std::make_unique<btBvhTriangleMeshShape>(triangles.get(), true);
	else shape = std::make_unique<btGImpactMeshShape>(triangles.get());
	shape->setMargin(marginOf(mesh));
	if (!fixed) static_cast<btGImpactMeshShape&>(*shape).updateBound();
	return {std::move(triangles), std::move(shape)};
}
}  // namespace browser
