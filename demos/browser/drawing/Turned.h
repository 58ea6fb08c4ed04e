// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <utility>
#include <vector>

namespace browser
{
/// Closed body of revolution about y. Its outline is a closed polygon in the half-plane (radius > 0, height), counter-clockwise when the
/// radius points right and y up. Edges are divided so that no part is longer than `piece` [m].
ist::Mesh turned(const std::vector<std::pair<double, double>>& outline, int segments, double piece);

/// An involute gear about y with a pressure angle of 20 degrees: `teeth` teeth of the module `module` [m], thickness `2 halfWidth`. The
/// teeth are narrower by `play` [m] at the pitch circle. A tooth points along +x.
ist::Mesh gear(int teeth, double module, double halfWidth, double play);
}  // namespace browser
