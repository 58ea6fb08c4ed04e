// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/World/btVolumetricInstallation.h"

#include "BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h"
#include "BulletDynamics/Dynamics/btDiscreteDynamicsWorldMt.h"
#include "BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h"

#include <typeinfo>

ist::Result<std::unique_ptr<btSequentialImpulseConstraintSolver>> installVolumetricSolver(
	btDiscreteDynamicsWorld& world, btISTRegistration& registration)
{
	if (!registration.refusal().empty()) return ist::Error{registration.refusal()};
	if (!registration.isRegistered())
		return ist::Error{"the registration does not hold all entries of a dispatcher: register the algorithm first, or reinstall it"};
	if (dynamic_cast<const btDiscreteDynamicsWorldMt*>(&world))
		return ist::Error{
			"the world may solve islands in several threads at once, which volumetric contact does not allow; its representative "
			"points are solved there"};
	auto* multiBodyWorld = dynamic_cast<btMultiBodyDynamicsWorld*>(&world);
	const btConstraintSolver* old = world.getConstraintSolver();
	if (!old) return ist::Error{"the world has no solver"};
	if (multiBodyWorld && typeid(*old) == typeid(btMultiBodyConstraintSolver))
	{
		auto multiBody = std::make_unique<btVolumetricSolver<btMultiBodyConstraintSolver>>(registration.sharedStore());
		multiBodyWorld->setMultiBodyConstraintSolver(multiBody.get());
		return std::unique_ptr<btSequentialImpulseConstraintSolver>(std::move(multiBody));
	}
	std::unique_ptr<btSequentialImpulseConstraintSolver> solver;
	if (!multiBodyWorld && typeid(*old) == typeid(btSequentialImpulseConstraintSolver))
		solver = std::make_unique<btVolumetricSolver<btSequentialImpulseConstraintSolver>>(registration.sharedStore());
	else if (!multiBodyWorld && typeid(*old) == typeid(btNNCGConstraintSolver))
		solver = std::make_unique<btVolumetricSolver<btNNCGConstraintSolver>>(registration.sharedStore());
	else
		return ist::Error{
			"volumetric contact is solved over btSequentialImpulseConstraintSolver, btNNCGConstraintSolver and, in a "
			"btMultiBodyDynamicsWorld, btMultiBodyConstraintSolver themselves; with any other solver its representative points are. "
			"A solver of your own may derive from btVolumetricSolver"};
	world.setConstraintSolver(solver.get());
	return solver;
}
