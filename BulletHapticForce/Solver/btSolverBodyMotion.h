// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Solver/btVolumetricRows.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletDynamics/ConstraintSolver/btSolverBody.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <algorithm>

/// Motion of the bodies in Bullet's solver pool, in double, for rows and islands. This header is not installed.
namespace btSolverBodyMotion
{
/// True when the body can rotate, which a body with a linear factor of zero may still do.
inline bool canTurn(const btRigidBody& body)
{
	if (!(body.getInvMass() > 0) || body.isStaticOrKinematicObject()) return false;
	const btVector3& factor = body.getAngularFactor();
	const btMatrix3x3& inertia = body.getInvInertiaTensorWorld();
	for (int i = 0; i < 3; ++i)
		if (factor[i] * inertia[i][i] * factor[i] > 0) return true;
	return false;
}

inline bool canMove(const btSolverBody& body)
{
	return body.m_originalBody && (!body.internalGetInvMass().isZero() || canTurn(*body.m_originalBody));
}

/// Mass of a body; zero for one that can only rotate, because it rests on nothing.
inline double massOf(const btSolverBody& body)
{
	const ist::Vec3 w = toVec3(body.internalGetInvMass());
	const double largest = std::max({w.x, w.y, w.z});
	return largest > 0 ? 1 / largest : 0;
}

inline btVolumetricRowBody rowBody(const btSolverBody& body)
{
	btVolumetricRowBody r;
	r.center = toVec3(body.getWorldTransform().getOrigin());
	if (!canMove(body)) return r;
	r.inverseMass = toVec3(body.internalGetInvMass());
	const btVector3& factor = body.m_originalBody->getAngularFactor();
	const btMatrix3x3& inertia = body.m_originalBody->getInvInertiaTensorWorld();
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) r.inverseInertia.m[i][j] = double(factor[i]) * double(inertia[i][j]) * double(factor[j]);
	return r;
}

/// Twist of the centre of mass, with all impulses that Bullet's rows and ours have applied so far.
inline ist::Twist twist(const btSolverBody& body)
{
	if (!body.m_originalBody) return {};
	return {toVec3(body.m_linearVelocity) + toVec3(body.m_externalForceImpulse) + toVec3(body.getDeltaLinearVelocity()),
		toVec3(body.m_angularVelocity) + toVec3(body.m_externalTorqueImpulse) + toVec3(body.getDeltaAngularVelocity())};
}

/// Transforms a twist of the body's centre of mass to a point [World].
inline ist::Twist movedTo(const ist::Twist& t, const btSolverBody& body, const ist::Vec3& point)
{
	return {t.linear + cross(t.angular, point - toVec3(body.getWorldTransform().getOrigin())), t.angular};
}

inline ist::Twist twistAt(const btSolverBody& body, const ist::Vec3& point) { return movedTo(twist(body), body, point); }

/// Change of a body's twist (at its centre of mass) by an impulse at a point.
inline ist::Twist response(const btVolumetricRowBody& r, const ist::Wrench& impulse, const ist::Vec3& point)
{
	return {componentProduct(r.inverseMass, impulse.force), r.inverseInertia * (impulse.torque + cross(point - r.center, impulse.force))};
}

/// Change of the twist of A minus that of B at a point by an impulse on A there and its opposite on B.
inline ist::SymmetricMatrix6 relativeResponse(const btVolumetricRowBody& A, const btVolumetricRowBody& B, const ist::Vec3& point)
{
	ist::SymmetricMatrix6 W;
	for (int column = 0; column < 6; ++column)
	{
		ist::Wrench one;
		(column < 3 ? one.force : one.torque)[column % 3] = 1;
		ist::Twist moved;
		for (const btVolumetricRowBody* body : {&A, &B})
		{
			const ist::Twist change = response(*body, one, point);
			moved = moved + ist::Twist{change.linear + cross(change.angular, point - body->center), change.angular};
		}
		for (int row = 0; row <= column; ++row) W(row, column) = row < 3 ? moved.linear[row] : moved.angular[row - 3];
	}
	return W;
}

inline void applyImpulse(btSolverBody& body, const ist::Wrench& impulse, const ist::Vec3& point)
{
	if (!canMove(body)) return;
	const ist::Twist change = response(rowBody(body), impulse, point);
	body.internalGetDeltaLinearVelocity() += toBullet(change.linear);
	body.internalGetDeltaAngularVelocity() += toBullet(change.angular);
}
}  // namespace btSolverBodyMotion
