// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

/// Matrices of btIslandBlockSolver. They are row major as far as the solver stores them so. Not installed.
namespace btIslandBlockMatrices
{
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using Axes = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;  // one axis per row
using Mat63 = Eigen::Matrix<double, 6, 3>;
using Mat46 = Eigen::Matrix<double, 4, 6>;
template <class M> using Map = Eigen::Map<M>;
}  // namespace btIslandBlockMatrices
