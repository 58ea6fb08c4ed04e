// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Law/btContactLaw.h"

#include <algorithm>

/// One ball of a patch's friction: its impulse on A is E t with |t| <= `coefficient` times the normal impulse, and opposes the slip E^T u,
/// with the twist u of A relative to B at the patch's point.
struct btFrictionBall
{
	double coefficient = 0;
	double E[18] = {};  ///< three wrenches about the patch's point, World axes, one after the other: force [1], torque [m]
};

/// Friction of a pair, as Bullet combines that of the two bodies.
struct btContactFriction
{
	static constexpr int kMostBalls = 2;

	double sliding = 0;   ///< Coulomb's coefficient
	double rolling = 0;   ///< largest moment about an axis along the surface, over the normal force [m]
	double spinning = 0;  ///< largest moment about the normal, over the normal force [m], besides that of sliding friction

	/// A value that is negative or no number counts as 0.
	btContactFriction(double slidingFriction = 0, double rollingFriction = 0, double spinningFriction = 0)
		: sliding(std::max(0.0, slidingFriction)),
		  rolling(std::max(0.0, rollingFriction)),
		  spinning(std::max(0.0, spinningFriction))
	{}

	/// Writes the balls that are not empty, at most kMostBalls, and returns their number. The first is sliding friction with the drilling
	/// moment over the friction radius. This is the ellipsoid that approximates the limit surface of a patch. The second is rolling and
	/// spinning friction.
	int balls(const btContactPatch& patch, btFrictionBall* out) const;
};
