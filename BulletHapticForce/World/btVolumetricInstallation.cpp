// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/World/btVolumetricInstallation.h"

#include "BulletISTCollision/Registry/btISTClassOf.h"

#include "BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h"
#include "BulletDynamics/Dynamics/btDiscreteDynamicsWorldMt.h"
#include "BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h"

namespace
{
const void* tableOfMultiBodyWorlds()
{
	const btMultiBodyDynamicsWorld example(nullptr, nullptr, nullptr, nullptr);
	return btISTVirtualTable(&example);
}

const void* tableOfThreadedWorlds()
{
	btConstraintSolverPoolMt pool(1);
	const btDiscreteDynamicsWorldMt example(nullptr, nullptr, &pool, nullptr, nullptr);
	return btISTVirtualTable(&example);
}
}  // namespace

ist::Result<std::unique_ptr<btSequentialImpulseConstraintSolver>> installVolumetricSolver(
	btDiscreteDynamicsWorld& world, btISTRegistration& registration)
{
	if (!registration.refusal().empty()) return ist::Error{registration.refusal()};
	if (!registration.isRegistered())
		return ist::Error{"the registration does not hold all entries of a dispatcher: register the algorithm first, or reinstall it"};
	if (btISTCast<const btDiscreteDynamicsWorldMt>(&world, tableOfThreadedWorlds))
		return ist::Error{
			"the world may solve islands in several threads at once, which volumetric contact does not allow; its representative "
			"points are solved there"};
	auto* multiBodyWorld = btISTCast<btMultiBodyDynamicsWorld>(&world, tableOfMultiBodyWorlds);
	const btConstraintSolver* old = world.getConstraintSolver();
	if (!old) return ist::Error{"the world has no solver"};
	if (multiBodyWorld && btISTIsExactly<btMultiBodyConstraintSolver>(*old))
	{
		auto multiBody = std::make_unique<btVolumetricSolver<btMultiBodyConstraintSolver>>(registration.sharedStore());
		multiBodyWorld->setMultiBodyConstraintSolver(multiBody.get());
		return std::unique_ptr<btSequentialImpulseConstraintSolver>(std::move(multiBody));
	}
	std::unique_ptr<btSequentialImpulseConstraintSolver> solver;
	if (!multiBodyWorld && btISTIsExactly<btSequentialImpulseConstraintSolver>(*old))
		solver = std::make_unique<btVolumetricSolver<btSequentialImpulseConstraintSolver>>(registration.sharedStore());
	else if (!multiBodyWorld && btISTIsExactly<btNNCGConstraintSolver>(*old))
		solver = std::make_unique<btVolumetricSolver<btNNCGConstraintSolver>>(registration.sharedStore());
	else
		return ist::Error{
			"volumetric contact is solved over btSequentialImpulseConstraintSolver, btNNCGConstraintSolver and, in a "
			"btMultiBodyDynamicsWorld, btMultiBodyConstraintSolver themselves; with any other solver its representative points are. "
			"A solver of your own may derive from btVolumetricSolver"};
	world.setConstraintSolver(solver.get());
	return solver;
}
