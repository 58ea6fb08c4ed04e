// SPDX-License-Identifier: Zlib
#include "tests/bench/peers/PeerContacts.h"

#include "tests/bench/bodies/PileBodies.h"

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "BulletCollision/CollisionDispatch/btCollisionObject.h"
#include "BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h"
#include "BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h"
#include "BulletCollision/CollisionDispatch/btManifoldResult.h"
#include "BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h"

#include <cmath>
#include <map>
#include <tuple>

using namespace ist;

namespace bench
{
namespace
{
/// Receives every contact that Bullet finds; a manifold would keep only four.
class AllContacts : public btManifoldResult
{
public:
	AllContacts(const btCollisionObjectWrapper* a, const btCollisionObjectWrapper* b)
		: btManifoldResult(a, b),
		  m_first(a->getCollisionObject())
	{}
	void addContactPoint(const btVector3& normalOnB, const btVector3&, btScalar depth) override
	{
		if (depth >= 0) return;
		// Algorithms may swap the bodies.
		const bool swapped = m_body0Wrap->getCollisionObject() != m_first;
		answer.push += Vec3{normalOnB.x(), normalOnB.y(), normalOnB.z()} * double(swapped ? depth : -depth);
		++answer.contacts;
	}
	PeerAnswer answer;

private:
	const btCollisionObject* m_first;
};

class BulletPeer : public Peer
{
public:
	BulletPeer(std::string name, PeerShape A, PeerShape B)
		: m_name(std::move(name)),
		  m_A(std::move(A)),
		  m_B(std::move(B)),
		  m_dispatcher(&m_configuration)
	{
		btGImpactCollisionAlgorithm::registerAlgorithm(&m_dispatcher);
		m_objectA.setCollisionShape(m_A.shape.get());
		m_objectB.setCollisionShape(m_B.shape.get());
		for (const PeerShape* s : {&m_A, &m_B})
		{
			s->shape->setMargin(0);
			if (auto* mesh = dynamic_cast<btGImpactShapeInterface*>(s->shape.get())) mesh->updateBound();
		}
	}
	std::string name() const override { return m_name; }
	PeerAnswer ask(const Pose& X) override
	{
		btMatrix3x3 R;
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j) R[i][j] = btScalar(X.rotation.m[i][j]);
		m_objectB.setWorldTransform(
			btTransform(R, btVector3(btScalar(X.translation.x), btScalar(X.translation.y), btScalar(X.translation.z))));
		const btCollisionObjectWrapper a(nullptr, m_A.shape.get(), &m_objectA, m_objectA.getWorldTransform(), -1, -1);
		const btCollisionObjectWrapper b(nullptr, m_B.shape.get(), &m_objectB, m_objectB.getWorldTransform(), -1, -1);
		btCollisionAlgorithm* algorithm = m_dispatcher.findAlgorithm(&a, &b, nullptr, BT_CONTACT_POINT_ALGORITHMS);
		AllContacts contacts(&a, &b);
		algorithm->processCollision(&a, &b, btDispatcherInfo(), &contacts);
		algorithm->~btCollisionAlgorithm();
		m_dispatcher.freeCollisionAlgorithm(algorithm);
		return contacts.answer;
	}

private:
	std::string m_name;
	PeerShape m_A, m_B;
	btDefaultCollisionConfiguration m_configuration;
	btCollisionDispatcher m_dispatcher;
	btCollisionObject m_objectA, m_objectB;
};

/// Merges the vertices in each cell of a grid, because HACD's time grows with the square of the number of triangles.
Mesh coarse(const Mesh& mesh, int cells)
{
	if (mesh.triangles.size() < 3000) return mesh;
	const double size = bounds(mesh).longestSide() / cells;
	std::map<std::tuple<int, int, int>, uint32_t> index;
	std::vector<uint32_t> to;
	Mesh result;
	for (const Vec3& p : mesh.vertices)
	{
		const auto cell = std::tuple(int(std::floor(p.x / size)), int(std::floor(p.y / size)), int(std::floor(p.z / size)));
		const auto [at, added] = index.emplace(cell, uint32_t(result.vertices.size()));
		if (added) result.vertices.push_back(p);
		to.push_back(at->second);
	}
	for (const auto& t : mesh.triangles)
	{
		const std::array<uint32_t, 3> corners{to[t[0]], to[t[1]], to[t[2]]};
		if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0]) result.triangles.push_back(corners);
	}
	return result;
}
}  // namespace

std::vector<std::unique_ptr<Peer>> makePeers(const Mesh& A, const Mesh& B)
{
	std::vector<std::unique_ptr<Peer>> peers;
	peers.push_back(std::make_unique<BulletPeer>("Bullet GImpact, all contacts", gimpactShape(A), gimpactShape(B)));
	constexpr int kCells = 24, kHulls = 12;
	PeerShape hullsA = hullsByHacd(coarse(A, kCells), kHulls), hullsB = hullsByHacd(coarse(B, kCells), kHulls);
	if (hullsA.shape && hullsB.shape)
	{
		const std::string name = "Bullet, hulls of HACD (" + std::to_string(hullsA.hulls) + " + " + std::to_string(hullsB.hulls) + ")";
		peers.push_back(std::make_unique<BulletPeer>(name, std::move(hullsA), std::move(hullsB)));
	}
#ifdef BENCH_HAS_FCL
	peers.push_back(makeFclPeer(A, B));
#endif
#ifdef BENCH_HAS_ODE
	peers.push_back(makeOdePeer(A, B));
#endif
	return peers;
}
}  // namespace bench
