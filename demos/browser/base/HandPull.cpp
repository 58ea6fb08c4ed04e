// SPDX-License-Identifier: Zlib
#include "demos/browser/base/HandPull.h"

#include "BulletISTCollision/Registry/btISTConversion.h"
#include "DeviceBridge/Coupling/VirtualCoupling.h"

#include <limits>

using namespace ist;

namespace browser
{
void HandPull::grab(btRigidBody* body)
{
	if (body->isStaticOrKinematicObject()) return;
	m_body = body;
	m_target = toPose(body->getWorldTransform());
}

void HandPull::release() { m_body = nullptr; }

void HandPull::move(const Vec3& shift, const Vec3& turn)
{
	m_target.translation += shift;
	m_target.rotation = rotationMatrix(quaternionFromRotationVector(turn)) * m_target.rotation;
	m_target.rotation = rotationMatrix(quaternion(m_target.rotation));
}

Wrench HandPull::pull(double h)
{
	if (!m_body) return {};
	m_body->activate();
	const double mass = 1 / double(m_body->getInvMass());
	const btVector3 inverses = m_body->getInvInertiaDiagLocal();
	const double inertia = 1 / double(inverses[inverses.maxAxis()]), k = mass * m_omega * m_omega, c = 2 * mass * m_omega;
	const double none = std::numeric_limits<double>::infinity();
	devicebridge::CouplingGains gains{k, inertia * m_omega * m_omega, c, 2 * inertia * m_omega, none, none};
	const devicebridge::ToolState tool{
		toPose(m_body->getWorldTransform()), {toVec3(m_body->getLinearVelocity()), toVec3(m_body->getAngularVelocity())}};
	const Wrench wrench = devicebridge::couplingOnTool(gains, m_target, {}, tool, mass, inertia, h);
	if (!isFinite(wrench)) return {};
	m_body->applyCentralForce(toBullet(wrench.force));
	m_body->applyTorque(toBullet(wrench.torque));
	return wrench;
}

double rayMeetsMesh(const Mesh& mesh, const Pose& X, const Vec3& from, const Vec3& direction)
{
	const Pose back = inverse(X);
	const Vec3 o = back * from, d = back.rotation * direction;
	double nearest = -1;
	for (const auto& triangle : mesh.triangles)
	{
		// This is the test of Moeller and Trumbore.
		const Vec3 &a = mesh.vertices[triangle[0]], ab = mesh.vertices[triangle[1]] - a, ac = mesh.vertices[triangle[2]] - a;
		const Vec3 p = cross(d, ac);
		const double det = dot(ab, p);
		if (det == 0) continue;
		const Vec3 s = o - a, q = cross(s, ab);
		const double u = dot(s, p) / det, v = dot(d, q) / det, t = dot(ac, q) / det;
		if (u >= 0 && v >= 0 && u + v <= 1 && t > 0 && (nearest < 0 || t < nearest)) nearest = t;
	}
	return nearest;
}
}  // namespace browser
