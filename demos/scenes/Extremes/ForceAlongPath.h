// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"

#include <functional>

namespace scenes
{
/// Force on A for k = 1 Pa/m [m^3] at a pose of B in A, in axes of A.
using ForceOfPose = std::function<ist::Vec3(const ist::Pose& X_AB)>;

/// A contact from which B moves away along a path.
struct PathStart
{
	ist::Pose X_AB;
	ist::Vec3 trueForce;  ///< force on A for k = 1 Pa/m [m^3]
	double size = 1;      ///< size of the smaller body [m]
};

/// Quality of a force along a path: how it changes from pose to pose, which a single pose cannot show.
struct PathQuality
{
	/// Noise while B slides sideways by a quarter of the size in a second, from 512 forces at 1 kHz: rms above 50 Hz, divided by the mean
	/// force. It includes the effect of the bodies' own corners, which is the same for every method.
	double noise = 0;
	/// Work on a circle through the contact with a radius of 1 % of the size, divided by the largest difference of energy on it. It is 0
	/// for a force that has a potential.
	double loopWork = 0;
	/// Additional depth at which B comes to rest under a load of the true force, as a share of the size; negative: less deep. NaN when no
	/// depth within a tenth of the size carries the load.
	double restDepth = 0;
	/// Largest increase of the force with depth on the slide [m^2]. Times k it is a stiffness [N/m].
	double stiffness = 0;
};

/// Follows the path. Cost: about 700 forces.
PathQuality followPath(const PathStart& start, const ForceOfPose& force);

/// Change of the force when the positions and axes of both bodies are rounded to floats at `distance` from the world's origin. Returns
/// its length divided by the force.
double changeInFloat(const PathStart& start, double distance, const ForceOfPose& force);
}  // namespace scenes
