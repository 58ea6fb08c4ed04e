// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletDynamics/Dynamics/btRigidBody.h"

namespace scenes
{
inline ist::Vec3 positionOf(const btRigidBody* body) { return toVec3(body->getWorldTransform().getOrigin()); }

/// Kinetic energy of a body with three equal moments of inertia [J].
inline double kineticEnergy(const btRigidBody* body, double mass, double inertia)
{
	const ist::Vec3 v = toVec3(body->getLinearVelocity()), w = toVec3(body->getAngularVelocity());
	return 0.5 * mass * dot(v, v) + 0.5 * inertia * dot(w, w);
}

/// Motion of two bodies of equal mass and isotropic inertia. The angular momentum is taken about their joint centre of mass.
struct PairMotion
{
	ist::Vec3 linear, angular;
	double kinetic = 0;

	PairMotion(const btRigidBody* const* bodies, double mass, double inertia)
	{
		const ist::Vec3 center = 0.5 * (positionOf(bodies[0]) + positionOf(bodies[1]));
		for (int i = 0; i < 2; ++i)
		{
			const ist::Vec3 v = toVec3(bodies[i]->getLinearVelocity());
			linear += mass * v;
			angular += cross(positionOf(bodies[i]) - center, mass * v) + inertia * toVec3(bodies[i]->getAngularVelocity());
			kinetic += kineticEnergy(bodies[i], mass, inertia);
		}
	}
};
}  // namespace scenes
