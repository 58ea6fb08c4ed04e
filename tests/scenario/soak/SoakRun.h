// SPDX-License-Identifier: Zlib
#pragma once

#include "tests/scenario/soak/SoakOperations.h"

#include <string>

namespace soak
{
/// Random worlds one after the other for so many simulated seconds, each in one of the solvers; a fourth of them calm, and those of
/// Bullet's NNCG solver, which throws bodies apart that are put into each other. The invariants:
/// - every pose is finite but that of a poisoned body, and of what Bullet's own contact handed the poison on to;
/// - in a calm world, of trees alone that fall into the pit, kinetic and potential energy never exceed what they were when nobody touched
/// anybody
///   last, and nobody leaves the pit;
/// - a contact callback that begins ends;
/// - contacts name bodies that are in the world; registry, store and manifolds are empty in the end;
/// - every allocation is given back: between two worlds always the same number live, of Bullet's and of operator new's.
/// `only`: every world is the one of this state, as a failure names it.
/// `folder`: for the trees, which are written, read again, damaged and refused.
Tally run(uint64_t seed, double seconds, const std::string& folder, std::optional<uint64_t> only = std::nullopt);
}  // namespace soak
