// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Solver/btVolumetricSolver.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"

#include <memory>

class btDiscreteDynamicsWorld;

/// Replaces a world's solver, one of Bullet's own, by the volumetric solver of the same kind. Returns the new solver; keep it for as long
/// as the world lives. It has default settings; the world's btContactSolverInfo stays. A game's world that derives from one of Bullet's
/// counts as that one. Its overrides still run, around the step and the solving of the base class.
///
/// Refused, with the reason and without any change: a registration that was released, a btDiscreteDynamicsWorldMt, and an unknown solver.
/// The known ones are exactly btSequentialImpulseConstraintSolver, btNNCGConstraintSolver and, in a multibody world,
/// btMultiBodyConstraintSolver. Others are MLCP, block and threaded solvers and a game's own: contact is then solved at its
/// representative points.
///
/// A world that was made without a solver owns its old one and frees it here. Otherwise the old solver stays with its owner.
ist::Result<std::unique_ptr<btSequentialImpulseConstraintSolver>> installVolumetricSolver(
	btDiscreteDynamicsWorld& world, btISTRegistration& registration);
