// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Solver/btVolumetricSolver.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"

#include <memory>

class btDiscreteDynamicsWorld;

/// Gives a world that solves with one of Bullet's own solvers the volumetric one of the same kind. The result is the new solver: keep
/// it for as long as the world lives. Its settings are those of a new one; the world's btContactSolverInfo stays. A game's own world,
/// derived from one of Bullet's, counts as that one: what it overrides it goes on doing, around the step and the solving of its base.
///
/// Refused, with the reason, and nothing changed: a solver that is not exactly btSequentialImpulseConstraintSolver,
/// btNNCGConstraintSolver or, in a multibody world, btMultiBodyConstraintSolver (MLCP, block and threaded solvers, and a game's own:
/// contact then stays with the representative points), a btDiscreteDynamicsWorldMt, a registration that was released.
/// A world that was made without a solver owns its old one and frees it here; otherwise the old one stays with whoever made it.
ist::Result<std::unique_ptr<btSequentialImpulseConstraintSolver>> installVolumetricSolver(
	btDiscreteDynamicsWorld& world, btISTRegistration& registration);
