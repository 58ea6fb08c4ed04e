// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletLinks.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletDynamics/Featherstone/btMultiBody.h"
#include "BulletDynamics/Featherstone/btMultiBodyLinkCollider.h"

#include <cmath>

namespace devicebridge
{
namespace
{
btVector3 unit(int axis)
{
	btVector3 v(0, 0, 0);
	v[axis] = 1;
	return v;
}

/// Sets the inverses of `out` to a bound of the response `m`, force first: out - m is positive semidefinite. The diagonal of what is left
/// out is at least the sum of its row (Gershgorin). A rotation counts by its displacement at the radius of gyration.
void bound(const double m[6][6], MirroredBody& out)
{
	const double linear = m[0][0] + m[1][1] + m[2][2], angular = m[3][3] + m[4][4] + m[5][5];
	const double length = linear > 0 && angular > 0 ? std::sqrt(linear / angular) : 1;
	const ist::Mat3& R = out.X_WB.rotation;
	ist::Mat3 turn = ist::zeroMat3();
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j)
		{
			out.inverseMass[i] += std::abs(m[i][j]) + length * std::abs(m[i][3 + j]);
			turn.m[i][j] += m[3 + i][3 + j];
			turn.m[i][i] += std::abs(m[j][3 + i]) / length;
		}
	out.inverseInertia = transpose(R) * turn * R;
}
}  // namespace

void BulletLinks::describe(const btMultiBodyLinkCollider& link, MirroredBody& out)
{
	const btMultiBody& multiBody = *link.m_multiBody;
	const int n = 6 + multiBody.getNumDofs();
	m_jacobian.resize(std::size_t(6 * n));
	m_response.resize(m_jacobian.size());
	const btScalar* velocity = multiBody.getVelocityVector();
	for (int row = 0; row < 6; ++row)
	{
		btScalar *J = &m_jacobian[std::size_t(row * n)], *response = &m_response[std::size_t(row * n)];
		const btVector3 along = row < 3 ? unit(row) : btVector3(0, 0, 0), about = row < 3 ? btVector3(0, 0, 0) : unit(row - 3);
		multiBody.fillConstraintJacobianMultiDof(
			link.m_link, link.getWorldTransform().getOrigin(), about, along, J, m_scratch, m_scratchVectors, m_scratchMatrices);
		multiBody.calcAccelerationDeltasMultiDof(J, response, m_scratch, m_scratchVectors);
		double speed = 0;
		for (int i = 0; i < n; ++i) speed += double(J[i]) * double(velocity[i]);
		(row < 3 ? out.twist.linear[row] : out.twist.angular[row - 3]) = speed;
	}
	double m[6][6] = {};
	for (int row = 0; row < 6; ++row)
		for (int column = 0; column < 6; ++column)
			for (int i = 0; i < n; ++i)
				m[row][column] += double(m_jacobian[std::size_t(row * n + i)]) * double(m_response[std::size_t(column * n + i)]);
	bound(m, out);
	if (isFinite(out.inverseMass) && isFinite(out.inverseInertia.row(0) + out.inverseInertia.row(1) + out.inverseInertia.row(2))) return;
	out.inverseMass = {};
	out.inverseInertia = ist::zeroMat3();
}

ist::Twist BulletLinks::twistOf(const btMultiBodyLinkCollider& link)
{
	ist::Twist twist;
	const btMultiBody& multiBody = *link.m_multiBody;
	if (!multiBody.isAwake()) return twist;
	const int n = 6 + multiBody.getNumDofs();
	const btScalar* velocity = multiBody.getVelocityVector();
	m_jacobian.resize(std::size_t(6 * n));
	for (int row = 0; row < 6; ++row)
	{
		btScalar* J = &m_jacobian[std::size_t(row * n)];
		const btVector3 along = row < 3 ? unit(row) : btVector3(0, 0, 0), about = row < 3 ? btVector3(0, 0, 0) : unit(row - 3);
		multiBody.fillConstraintJacobianMultiDof(
			link.m_link, link.getWorldTransform().getOrigin(), about, along, J, m_scratch, m_scratchVectors, m_scratchMatrices);
		double& speed = row < 3 ? twist.linear[row] : twist.angular[row - 3];
		for (int i = 0; i < n; ++i) speed += double(J[i]) * double(velocity[i]);
	}
	return twist;
}

double BulletLinks::massOf(const btMultiBodyLinkCollider& link)
{
	return double(link.m_link < 0 ? link.m_multiBody->getBaseMass() : link.m_multiBody->getLink(link.m_link).m_mass);
}

void BulletLinks::push(const btMultiBodyLinkCollider& link, const ist::Wrench& wrench)
{
	btMultiBody& multiBody = *link.m_multiBody;
	const btVector3 force = toBullet(wrench.force), torque = toBullet(wrench.torque);
	if (link.m_link < 0)
	{
		multiBody.addBaseForce(force);
		multiBody.addBaseTorque(torque);
	}
	else
	{
		multiBody.addLinkForce(link.m_link, force);
		multiBody.addLinkTorque(link.m_link, torque);
	}
	multiBody.wakeUp();
}
}  // namespace devicebridge
