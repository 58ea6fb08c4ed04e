// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/btVolumetricInstallation.h"

#include "BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h"
#include "BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h"
#include "BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h"

#include <typeinfo>

ist::Result<std::unique_ptr<btSequentialImpulseConstraintSolver>> installVolumetricSolver(btDiscreteDynamicsWorld& world,
																						  btISTRegistration& registration)
{
	if (!registration.isRegistered())
		return ist::Error{"the registration does not hold all entries of a dispatcher: register the algorithm first, or reinstall it"};
	const bool hasLinks = typeid(world) == typeid(btMultiBodyDynamicsWorld);
	if (!hasLinks && typeid(world) != typeid(btDiscreteDynamicsWorld))
		return ist::Error{"volumetric contact is solved in btDiscreteDynamicsWorld and btMultiBodyDynamicsWorld only; in other worlds its "
						  "representative points are"};
	const btConstraintSolver* old = world.getConstraintSolver();
	if (!old) return ist::Error{"the world has no solver"};
	if (hasLinks && typeid(*old) == typeid(btMultiBodyConstraintSolver))
	{
		auto multiBody = std::make_unique<btVolumetricSolver<btMultiBodyConstraintSolver>>(registration.sharedStore());
		static_cast<btMultiBodyDynamicsWorld&>(world).setMultiBodyConstraintSolver(multiBody.get());
		return std::unique_ptr<btSequentialImpulseConstraintSolver>(std::move(multiBody));
	}
	std::unique_ptr<btSequentialImpulseConstraintSolver> solver;
	if (!hasLinks && typeid(*old) == typeid(btSequentialImpulseConstraintSolver))
		solver = std::make_unique<btVolumetricSolver<btSequentialImpulseConstraintSolver>>(registration.sharedStore());
	else if (!hasLinks && typeid(*old) == typeid(btNNCGConstraintSolver))
		solver = std::make_unique<btVolumetricSolver<btNNCGConstraintSolver>>(registration.sharedStore());
	else
		return ist::Error{
			"volumetric contact is solved over btSequentialImpulseConstraintSolver, btNNCGConstraintSolver and, in a "
			"btMultiBodyDynamicsWorld, btMultiBodyConstraintSolver themselves; with any other solver its representative points are. "
			"A solver of your own may derive from btVolumetricSolver"};
	world.setConstraintSolver(solver.get());
	return solver;
}
