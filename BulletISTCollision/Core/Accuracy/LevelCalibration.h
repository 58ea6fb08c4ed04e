// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

namespace ist
{
/// How much a body's levels err: for the leaves and for each of `tree.levels` the coefficient c of the law
///     |F - F_true| = c k V sqrt(1/n_A + 1/n_B),   n = balls of the level that share the overlap, on the average: their number times V over
///     the body's volume,
/// that holds in 95 % of poses, V being the overlap. Measured on the body against itself in seeded poses of 0.1 to 20 % overlap, each level
/// beside the leaves; the leaves, which have nothing finer beside them, get the coefficient of the first level. Round bodies would need
/// 0.05 to 0.15, those thinner than a level's balls up to 0.5. Kept within 0.15 to 0.4, the range in which the law was compared with
/// quadrature (bench_pareto). Levels must be there. The same for any thread count; some hundred queries.
std::vector<double> measuredCalibration(const InnerSphereTree& tree, int threads = 1);

bool hasLevels(const InnerSphereTree& tree);

/// Builds the levels of a tree and measures their calibration, unless it has them.
void addLevels(InnerSphereTree& tree, int threads = 1);
}  // namespace ist
