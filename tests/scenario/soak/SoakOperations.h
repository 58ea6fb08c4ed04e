// SPDX-License-Identifier: Zlib
#pragma once

#include "tests/scenario/soak/SoakWorld.h"

#include <cstdint>

namespace soak
{
/// Counts of what was done so far.
struct Tally
{
	uint64_t worlds = 0, steps = 0, operations = 0, poisoned = 0, refused = 0, contacts = 0, broughtBack = 0;
	double worstGain = 0;     ///< largest energy gain of a calm world since no bodies touched, as a share of the energy then
	long liveAfter = 0;       ///< number of live allocations between two worlds
	double mostResident = 0;  ///< largest resident memory [MB]
};

/// Does one random thing that a game may do to its world between two steps.
void disturb(SoakWorld& world, Random& random, Tally& tally);
/// Does something that a game should never do: it sets a pose, velocity or force that is not finite or absurdly large. The actor is
/// marked as poisoned. Returns null in an empty world.
Actor* poison(SoakWorld& world, Random& random, Tally& tally);
/// Makes calls that must be refused with a reason and change nothing.
void expectRefusals(SoakWorld& world, Random& random, Tally& tally);
}  // namespace soak
