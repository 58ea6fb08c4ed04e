// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

namespace ist
{
/// Measures the force errors of a body's levels. For the leaves and for each of `tree.levels` it gives the coefficient c of the law
///     |F - F_true| = c k V sqrt(1/n_A + 1/n_B),
/// which holds in 95 % of poses. k is the stiffness [Pa/m] and V the overlap volume. n is the mean number of balls in the overlap: the
/// level's number of balls times V over the body's volume. The body is measured against itself in seeded poses of 0.1 to 20 % overlap, each
/// level relative to the leaves. The leaves have no finer reference, so they get the coefficient of the first level. Round bodies need 0.05
/// to 0.15, and bodies thinner than a level's balls up to 0.5. The coefficients are limited to 0.15 to 0.4, the range in which the law was
/// compared with quadrature (bench_pareto). The levels must exist. The result is the same for any thread count. Cost: a few hundred
/// queries.
std::vector<double> measuredCalibration(const InnerSphereTree& tree, int threads = 1);

bool hasLevels(const InnerSphereTree& tree);

/// Builds the levels of a tree and measures their calibration, unless it has them.
void addLevels(InnerSphereTree& tree, int threads = 1);
}  // namespace ist
