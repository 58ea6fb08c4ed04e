// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Accuracy/AdaptiveLevel.h"
#include "demos/scenes/Truth/OverlapQuadrature.h"

#include <vector>

namespace scenes
{
/// A pose with its true force.
struct JudgedPose
{
	ist::Pose X_AB;
	ist::Vec3 force;       ///< force on A for 1 Pa/m, by quadrature on the triangles [m^3]
	double uncertain = 0;  ///< standard error of `force` [m^3]
};
/// Computes the true forces. Uses all hardware threads.
std::vector<JudgedPose> judgePoses(const OverlapQuadrature& truth, const std::vector<ist::Pose>& poses, int linesPerAxis, int pointsTotal);

/// Error of a force against the truth, as a share of the larger of the truth and the force floor. The error bound is a bound of this
/// error.
double forceError(const ist::Vec3& force, const JudgedPose& truth, double floor);

/// Result of one accepted error over all poses. Except for counts and shares, a value is either the median over the poses or the 95th
/// percentile.
struct AccuracyPoint
{
	double accepted = 0;          ///< accepted error, as a share of the force
	double pairs = 0, balls = 0;  ///< pairs found, and balls in both levels that answered; median
	double microseconds = 0;      ///< time of a query [us], median
	double errorBound = 0;        ///< error bound, 95th percentile
	double medianErrorBound = 0;
	double error = 0;        ///< true error, 95th percentile
	double middleError = 0;  ///< true error, median
	double held = 0;         ///< share of the poses whose true error is within the error bound
	double kept = 0;         ///< share of the poses whose error bound is within the accepted error
};

/// Runs the sweep. Both trees must have their levels (ist::addLevels). Each query starts with the level of the pose before, as for a pair
/// that moves.
std::vector<AccuracyPoint> sweepAccuracy(const ist::InnerSphereTree& A, const ist::InnerSphereTree& B, const std::vector<JudgedPose>& poses,
	const std::vector<double>& accepted);
}  // namespace scenes
