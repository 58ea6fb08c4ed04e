// SPDX-License-Identifier: Zlib
#include "tests/bench/peers/PeerContacts.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/collision.h>

using namespace ist;

namespace bench
{
namespace
{
using Model = fcl::BVHModel<fcl::OBBRSSd>;

std::shared_ptr<Model> modelOf(const Mesh& mesh)
{
	auto model = std::make_shared<Model>();
	std::vector<fcl::Vector3d> points;
	std::vector<fcl::Triangle> triangles;
	for (const Vec3& p : mesh.vertices) points.emplace_back(p.x, p.y, p.z);
	for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
	model->beginModel();
	model->addSubModel(points, triangles);
	model->endModel();
	return model;
}

class Fcl : public Peer
{
public:
	Fcl(const Mesh& A, const Mesh& B) : m_A(modelOf(A), fcl::Transform3d::Identity()), m_B(modelOf(B), fcl::Transform3d::Identity()) {}
	std::string name() const override { return "FCL, all contacts"; }
	PeerAnswer ask(const Pose& X) override
	{
		fcl::Transform3d T = fcl::Transform3d::Identity();
		for (int i = 0; i < 3; ++i)
		{
			for (int j = 0; j < 3; ++j) T.linear()(i, j) = X.rotation.m[i][j];
			T.translation()[i] = X.translation[i];
		}
		m_B.setTransform(T);
		const fcl::CollisionRequestd request(1000000, true);
		fcl::CollisionResultd result;
		fcl::collide(&m_A, &m_B, request, result);
		std::vector<fcl::Contactd> contacts;
		result.getContacts(contacts);
		PeerAnswer answer;
		answer.contacts = int(contacts.size());
		for (const fcl::Contactd& c : contacts) answer.push += Vec3{c.normal[0], c.normal[1], c.normal[2]} * -c.penetration_depth;
		return answer;
	}

private:
	fcl::CollisionObjectd m_A, m_B;
};
}  // namespace

std::unique_ptr<Peer> makeFclPeer(const Mesh& A, const Mesh& B) { return std::make_unique<Fcl>(A, B); }
}  // namespace bench
