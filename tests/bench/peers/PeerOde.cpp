// SPDX-License-Identifier: Zlib
#include "tests/bench/peers/PeerContacts.h"

#include <ode/ode.h>

using namespace ist;

namespace bench
{
namespace
{
void beSilent(int, const char*, va_list) {}

/// A triangle mesh in ODE's own arrays.
class OdeMesh
{
public:
	explicit OdeMesh(const Mesh& mesh)
	{
		for (const Vec3& p : mesh.vertices)
			for (int i = 0; i < 3; ++i) m_points.push_back(p[i]);
		for (const auto& t : mesh.triangles) m_corners.insert(m_corners.end(), {t[0], t[1], t[2]});
		m_mesh = dGeomTriMeshDataCreate();
		dGeomTriMeshDataBuildDouble(m_mesh, m_points.data(), 3 * sizeof(double), int(mesh.vertices.size()), m_corners.data(),
			int(m_corners.size()), 3 * sizeof(dTriIndex));
		m_geometry = dCreateTriMesh(nullptr, m_mesh, nullptr, nullptr, nullptr);
	}
	~OdeMesh()
	{
		dGeomDestroy(m_geometry);
		dGeomTriMeshDataDestroy(m_mesh);
	}
	OdeMesh(const OdeMesh&) = delete;
	dGeomID geometry() const { return m_geometry; }

private:
	std::vector<double> m_points;
	std::vector<dTriIndex> m_corners;
	dTriMeshDataID m_mesh;
	dGeomID m_geometry;
};

class Ode : public Peer
{
public:
	Ode(const Mesh& A, const Mesh& B) : m_A(A), m_B(B), m_contacts(60000) {}
	std::string name() const override { return "ODE trimesh"; }
	PeerAnswer ask(const Pose& X) override
	{
		dMatrix3 R = {};
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j) R[4 * i + j] = dReal(X.rotation.m[i][j]);
		dGeomSetRotation(m_B.geometry(), R);
		dGeomSetPosition(m_B.geometry(), dReal(X.translation.x), dReal(X.translation.y), dReal(X.translation.z));
		PeerAnswer answer;
		answer.contacts = dCollide(m_A.geometry(), m_B.geometry(), int(m_contacts.size()), m_contacts.data(), sizeof(dContactGeom));
		for (int i = 0; i < answer.contacts; ++i)
		{
			const dContactGeom& c = m_contacts[size_t(i)];
			answer.push += Vec3{double(c.normal[0]), double(c.normal[1]), double(c.normal[2])} * double(c.depth);
		}
		return answer;
	}

private:
	struct Library
	{
		Library()
		{
			dInitODE2(0);
			// ODE prints a line for each full bucket of contacts.
			dSetMessageHandler(&beSilent);
		}
		~Library() { dCloseODE(); }
	};
	Library m_library;
	OdeMesh m_A, m_B;
	std::vector<dContactGeom> m_contacts;
};
}  // namespace

std::unique_ptr<Peer> makeOdePeer(const Mesh& A, const Mesh& B) { return std::make_unique<Ode>(A, B); }
}  // namespace bench
