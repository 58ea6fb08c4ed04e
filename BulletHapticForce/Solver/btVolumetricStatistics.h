// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>

/// What a solver did since it was made: every fallback and clamp is counted. Take the difference of two readings for one step.
struct btVolumetricStatistics
{
	uint64_t patches = 0;                   ///< solved
	uint64_t islands = 0;                   ///< solved at once
	uint64_t islandsTooLarge = 0;           ///< solved patch by patch, in Bullet's iterations
	uint64_t activeSetRounds = 0;           ///< of all block solves
	uint64_t frictionNotConverged = 0;      ///< block solves whose friction sweeps ended before the impulses stood still
	uint64_t blocksNotFactorised = 0;       ///< exerted nothing: input that is not finite
	uint64_t contactsHeldToEnergyTank = 0;  ///< would have returned more than they had absorbed, and were held back
	uint64_t contactsTurnedOver = 0;        ///< force against that of the step before: one was pushed, or fell, through the other
	uint64_t contactsTooDeep = 0;  ///< in this step deeper than a quarter of the thinner body (btISTContact::thickness): it may be pushed
								   ///< through, and wants a stiffness
	uint64_t contactsPrecisionLost = 0;  ///< solved, but the force may be a twentieth off: btScalar places bodies too coarsely there
	uint64_t contactsStale = 0;          ///< left to their representative points, as not evaluated in this step
	uint64_t contactsNotRigid = 0;       ///< the same, as a body is neither a rigid body nor a link that the solver knows
	uint64_t contactsNotFinite = 0;      ///< exerted nothing: velocity, pose, mass or step of a body is not a finite number
	uint64_t contactsRefused = 0;        ///< exerted nothing: the query refused the poses (QueryStatus)
	uint64_t patchesWithoutForce = 0;    ///< overlap beyond the medial axis, or not finite
};
