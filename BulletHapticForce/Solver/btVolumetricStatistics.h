// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>

/// Counters of a solver since it was made, with every fallback and limit. For the counts of one step, take the difference of two
/// readings.
struct btVolumetricStatistics
{
	uint64_t patches = 0;          ///< patches that were solved
	uint64_t islands = 0;          ///< islands that were solved at once
	uint64_t islandsTooLarge = 0;  ///< islands that were solved patch by patch, in Bullet's iterations
	uint64_t activeSetRounds = 0;  ///< rounds of the active sets, over all block solves
	/// block solves whose rounds ended before the patches were found that push: one that would push may have exerted nothing
	uint64_t activeSetsNotFound = 0;
	uint64_t frictionNotConverged = 0;  ///< block solves whose search for friction ended before it converged
	uint64_t blocksNotFactorised = 0;   ///< block solves that exerted nothing, because of input that is not finite
	uint64_t solvedAgain = 0;           ///< solves that were repeated, because deflected bodies would have gone deep into others
	/// bodies that moved for a part of a step only, because it brought two of their island deep into each other however often it was solved
	uint64_t bodiesHeld = 0;
	/// contacts whose impulses were reduced, because they would have returned more energy than was stored
	uint64_t contactsHeldToEnergyTank = 0;
	/// contacts whose force has reversed since the step before: one body was pushed, or fell, through the other
	uint64_t contactsTurnedOver = 0;
	/// contacts that are deeper in this step than a tenth of the thinner body (btISTContact::isDeep): a body may be pushed through;
	/// set a stiffness
	uint64_t contactsTooDeep = 0;
	/// contacts whose force may be 5 % off, because btScalar rounds the bodies' positions too coarsely there
	uint64_t contactsPrecisionLost = 0;
	/// contacts that Bullet solved at their representative points, because they were not evaluated in this step
	uint64_t contactsStale = 0;
	/// contacts that Bullet solved so, because a body is neither a rigid body nor a link that the solver knows
	uint64_t contactsNotRigid = 0;
	uint64_t contactsNotFinite = 0;    ///< contacts without force, because the velocity, pose, mass or step of a body is not finite
	uint64_t contactsRefused = 0;      ///< contacts without force, because the query refused the poses (QueryStatus)
	uint64_t patchesWithoutForce = 0;  ///< patches without force: the overlap lies beyond the medial axis, or is not finite
};
