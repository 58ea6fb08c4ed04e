// SPDX-License-Identifier: Zlib
#include "tests/bench/bodies/PileBodies.h"

#include "BulletCollision/CollisionShapes/btCompoundShape.h"
#include "BulletCollision/CollisionShapes/btConvexHullShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "BulletCollision/Gimpact/btGImpactShape.h"

#ifdef BENCH_HAS_HACD
#include <hacdHACD.h>
#endif

namespace bench
{
PeerShape gimpactShape(const ist::Mesh& mesh)
{
	auto triangles = std::make_shared<btTriangleMesh>();
	const auto corner = [&](int i) {
		const ist::Vec3& p = mesh.vertices[size_t(i)];
		return btVector3(btScalar(p.x), btScalar(p.y), btScalar(p.z));
	};
	for (const auto& t : mesh.triangles) triangles->addTriangle(corner(int(t[0])), corner(int(t[1])), corner(int(t[2])));
	auto shape = std::make_shared<btGImpactMeshShape>(triangles.get());
	shape->setMargin(btScalar(0.005));
	shape->updateBound();
	return {{triangles}, shape, 0};
}

#ifdef BENCH_HAS_HACD
PeerShape hullsByHacd(const ist::Mesh& mesh, int clusters)
{
	std::vector<HACD::Vec3<HACD::Real>> points;
	std::vector<HACD::Vec3<long>> triangles;
	for (const ist::Vec3& p : mesh.vertices) points.emplace_back(p.x, p.y, p.z);
	for (const auto& t : mesh.triangles) triangles.emplace_back(long(t[0]), long(t[1]), long(t[2]));
	HACD::HACD hacd;
	hacd.SetPoints(points.data());
	hacd.SetNPoints(points.size());
	hacd.SetTriangles(triangles.data());
	hacd.SetNTriangles(triangles.size());
	hacd.SetCompacityWeight(0.1);
	hacd.SetVolumeWeight(0);
	hacd.SetNClusters(size_t(clusters));
	hacd.SetNVerticesPerCH(100);
	hacd.SetConcavity(100);  // unit: HACD's own scale, in which the mesh is 1000 wide
	hacd.SetAddExtraDistPoints(false);
	hacd.SetAddNeighboursDistPoints(false);
	hacd.SetAddFacesPoints(false);
	hacd.Compute();
	PeerShape result;
	auto compound = std::make_shared<btCompoundShape>();
	for (size_t c = 0; c < hacd.GetNClusters(); ++c)
	{
		std::vector<HACD::Vec3<HACD::Real>> hull(hacd.GetNPointsCH(c));
		std::vector<HACD::Vec3<long>> faces(hacd.GetNTrianglesCH(c));
		hacd.GetCH(c, hull.data(), faces.data());
		auto shape = std::make_shared<btConvexHullShape>();
		for (auto& p : hull) shape->addPoint(btVector3(btScalar(p.X()), btScalar(p.Y()), btScalar(p.Z())), false);
		shape->recalcLocalAabb();
		shape->setMargin(btScalar(0.005));
		compound->addChildShape(btTransform::getIdentity(), shape.get());
		result.parts.push_back(shape);
	}
	result.hulls = int(hacd.GetNClusters());
	result.shape = compound;
	return result;
}
#else
PeerShape hullsByHacd(const ist::Mesh&, int) { return {}; }
#endif
}  // namespace bench
