// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"

namespace devicebridge
{
/// Velocity of the tool for the deflection of a 6-DOF mouse.
struct SpnavRates
{
	double fullDeflection = 350;  ///< counts of spacenavd at its default sensitivity
	double speed = 0.1;           ///< speed at full deflection [m/s]
	double turn = 1;              ///< angular speed at full deflection [rad/s]
};

/// Twist in W = x to the right, y up, z towards the user. spacenavd counts along and about z with the opposite sign, as
/// spnav_posrot_moveobj() of libspnav 1.0 shows.
inline ist::Twist twistOf(const int (&counts)[6], const SpnavRates& rates)
{
	const double v = rates.speed / rates.fullDeflection, w = rates.turn / rates.fullDeflection;
	return {{v * counts[0], v * counts[1], -v * counts[2]}, {w * counts[3], w * counts[4], -w * counts[5]}};
}
}  // namespace devicebridge
