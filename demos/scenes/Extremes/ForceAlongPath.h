// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"

#include <functional>

namespace scenes
{
/// Force on A for k = 1 Pa/m [m^3] at a pose of B in A; axes of A.
using ForceOfPose = std::function<ist::Vec3(const ist::Pose& X_AB)>;

/// A contact from which B is led away and back.
struct PathStart
{
	ist::Pose X_AB;
	ist::Vec3 trueForce;  ///< on A for k = 1 Pa/m [m^3]
	double size = 1;      ///< of the smaller body [m]
};

/// What cannot be seen in one pose: how a force changes from pose to pose.
struct PathQuality
{
	/// While B slides sideways by a quarter of the size in a second, 512 forces at 1 kHz: rms above 50 Hz, over the mean force. What the
	/// bodies' own corners add is in it, the same for everything that is led along the path.
	double noise = 0;
	/// Work on a circle of 1 % of the size through the contact, over the largest difference of energy on it; 0 of a force that has a
	/// potential.
	double loopWork = 0;
	/// How much deeper B comes to rest under a load of the true force, of the size; negative: less deep. Not a number where nothing within
	/// a tenth of the size bears it.
	double restDepth = 0;
	/// Largest growth of the force with depth on the slide [m^2]; times k it is a stiffness [N/m].
	double stiffness = 0;
};

/// About 700 forces.
PathQuality followPath(const PathStart& start, const ForceOfPose& force);

/// Length of what the force changes by when the places of both bodies, and their axes, are rounded to floats, `distance` from the origin of
/// the world; over the force.
double changeInFloat(const PathStart& start, double distance, const ForceOfPose& force);
}  // namespace scenes
