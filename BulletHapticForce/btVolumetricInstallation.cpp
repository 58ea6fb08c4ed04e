// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/btVolumetricInstallation.h"

#include "BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h"
#include "BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h"

#include <typeinfo>

ist::Result<std::unique_ptr<btSequentialImpulseConstraintSolver>> installVolumetricSolver(btDiscreteDynamicsWorld& world,
																						  btISTRegistration& registration)
{
	if (!registration.isRegistered())
		return ist::Error{"the registration does not hold all entries of a dispatcher: register the algorithm first, or reinstall it"};
	if (typeid(world) != typeid(btDiscreteDynamicsWorld))
		return ist::Error{"volumetric contact is solved in a btDiscreteDynamicsWorld only; in other worlds its representative points are"};
	const btConstraintSolver* old = world.getConstraintSolver();
	if (!old) return ist::Error{"the world has no solver"};
	std::unique_ptr<btSequentialImpulseConstraintSolver> solver;
	if (typeid(*old) == typeid(btSequentialImpulseConstraintSolver))
		solver = std::make_unique<btVolumetricSolver<btSequentialImpulseConstraintSolver>>(registration.sharedStore());
	else if (typeid(*old) == typeid(btNNCGConstraintSolver))
		solver = std::make_unique<btVolumetricSolver<btNNCGConstraintSolver>>(registration.sharedStore());
	else
		return ist::Error{
			"volumetric contact is solved over btSequentialImpulseConstraintSolver and btNNCGConstraintSolver themselves; with any other "
			"solver its representative points are. A solver of your own may derive from btVolumetricSolver"};
	world.setConstraintSolver(solver.get());
	return solver;
}
