// SPDX-License-Identifier: Zlib
#pragma once

#include "tests/scenario/soak/SoakWorld.h"

#include <cstdint>

namespace soak
{
/// What was done so far.
struct Tally
{
	uint64_t worlds = 0, steps = 0, operations = 0, poisoned = 0, refused = 0, contacts = 0, broughtBack = 0;
	double worstGain = 0;     ///< of energy in a calm world over what it had when nobody touched anybody last, as a share of that
	long liveAfter = 0;       ///< allocations that live between two worlds
	double mostResident = 0;  ///< [MB]
};

/// One random thing that a game may do to its world between two steps.
void disturb(SoakWorld& world, Random& random, Tally& tally);
/// What no game should do, and every game does once: a pose, a velocity or a force that is no number, or absurd. The actor is marked; null
/// in an empty world.
Actor* poison(SoakWorld& world, Random& random, Tally& tally);
/// Calls that must be refused with a reason and change nothing.
void expectRefusals(SoakWorld& world, Random& random, Tally& tally);
}  // namespace soak
