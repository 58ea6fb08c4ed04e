// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Accuracy/AdaptiveLevel.h"
#include "demos/scenes/Truth/OverlapQuadrature.h"

#include <vector>

namespace scenes
{
/// A pose with the truth about it.
struct JudgedPose
{
	ist::Pose X_AB;
	ist::Vec3 force;       ///< on A for 1 Pa/m, by quadrature on the triangles [m^3]
	double uncertain = 0;  ///< its standard error [m^3]
};
/// In as many threads as there are.
std::vector<JudgedPose> judgePoses(const OverlapQuadrature& truth, const std::vector<ist::Pose>& poses, int linesPerAxis, int pointsTotal);

/// Error of a force against the truth, as a share of the larger of the truth and the error bound's floor: what a error bound speaks of.
double forceError(const ist::Vec3& force, const JudgedPose& truth, double floor);

/// What one error accepted comes to over all poses. All but counts and shares are of the pose in the middle, or of that which 95 % stay
/// under.
struct AccuracyPoint
{
	double accepted = 0;          ///< share of the force
	double pairs = 0, balls = 0;  ///< found, and in both levels that answered; middle
	double microseconds = 0;      ///< of a query, middle
	double errorBound = 0;        ///< of 95 %
	double medianErrorBound = 0;
	double error = 0;        ///< true, of 95 %
	double middleError = 0;  ///< true
	double held = 0;         ///< share of the poses whose true error is within the error bound
	double kept = 0;         ///< share whose error bound is within what is accepted
};

/// Both trees have their levels (ist::addLevels). Each pose is asked as one of a pair that moves: with the level of the pose before.
std::vector<AccuracyPoint> sweepAccuracy(const ist::InnerSphereTree& A, const ist::InnerSphereTree& B, const std::vector<JudgedPose>& poses,
	const std::vector<double>& accepted);
}  // namespace scenes
