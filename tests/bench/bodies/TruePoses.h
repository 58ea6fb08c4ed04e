// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Truth/OverlapQuadrature.h"

#include <string>
#include <vector>

namespace bench
{
/// A pose of B in A with the wrench and volume of the continuum law.
struct TruePose
{
	ist::Pose X_AB;
	double overlap = 0;             ///< requested overlap, as a share of the smaller body's volume
	scenes::QuadratureTruth truth;  ///< torques about A's centre of volume
};

/// Resolution of the reference quadrature.
struct TruthSettings
{
	std::vector<double> overlaps;
	int poses = 10;  ///< number of poses for each overlap
	int lines = 100, points = 30000;
	uint64_t seed = 11;
};

/// Seeded random poses of two bodies of `meshNamed`, placed, with a reference by quadrature on their triangles. If `folder` is not
/// empty, the results are kept there from run to run.
std::vector<TruePose> truePoses(
	const std::string& bodyA, const std::string& bodyB, const TruthSettings& settings, const std::string& folder = {});
}  // namespace bench
