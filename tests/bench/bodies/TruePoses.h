// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Truth/OverlapQuadrature.h"

#include <string>
#include <vector>

namespace bench
{
/// A pose of B in A with what the continuum law says of it.
struct TruePose
{
	ist::Pose X_AB;
	double overlap = 0;             ///< share of the smaller body's volume that was asked for
	scenes::QuadratureTruth truth;  ///< torques about A's centre of volume
};

/// How finely the truth is looked for.
struct TruthSettings
{
	std::vector<double> overlaps;
	int poses = 10;  ///< for each overlap
	int lines = 100, points = 30000;
	uint64_t seed = 11;
};

/// Seeded random poses of two of the bodies of `meshNamed`, placed; the truth by quadrature on their triangles. `folder`, when not empty,
/// keeps what was integrated from run to run.
std::vector<TruePose> truePoses(
	const std::string& bodyA, const std::string& bodyB, const TruthSettings& settings, const std::string& folder = {});
}  // namespace bench
