// SPDX-License-Identifier: Zlib
#pragma once

#include "tests/scenario/soak/SoakOperations.h"

#include <string>

namespace soak
{
/// Runs random worlds in sequence for so many simulated seconds, each with one of the solvers. A quarter of the worlds is calm, as are
/// all worlds with Bullet's NNCG solver, which throws interpenetrating bodies apart. The invariants are:
/// - Every pose is finite, except those of poisoned bodies, and of bodies that Bullet's own contact has poisoned in turn.
/// - Calm worlds contain only trees that fall into the pit. There the kinetic and potential energy never exceeds its value when no bodies
/// touched, and no body leaves the pit.
/// - Every contact callback that begins also ends.
/// - Contacts refer to bodies in the world. At the end, registry, store and manifolds are empty.
/// - Every allocation is freed: between two worlds the number of live allocations, of Bullet's allocator and of operator new, is always
/// the same.
/// `only`: every world has this random state, which a failure reports.
/// `folder`: the trees are written there, read again, damaged and refused.
Tally run(uint64_t seed, double seconds, const std::string& folder, std::optional<uint64_t> only = std::nullopt);
}  // namespace soak
