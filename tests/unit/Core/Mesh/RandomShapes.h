// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Geometry/MomentEllipsoid.h"

#include <random>

inline void makeRound(ist::MomentEllipsoid& e)
{
	e.xx = e.yy = e.zz = e.R * e.R;
	e.xy = e.xz = e.yz = 0;
}

/// Gives an ellipsoid half-axes in random directions. The longest is slightly below R; the others are at least `flattest` times as
/// long. The density becomes the ellipsoid's own.
template <class Random> void giveRandomShape(ist::MomentEllipsoid& e, Random& random, double flattest = 0.25)
{
	std::uniform_real_distribution<double> turn(-3, 3), axis(flattest, 1);
	const double longest = e.R * (1 - 1e-6), b = longest * axis(random), c = longest * axis(random);
	const ist::Mat3 R = ist::rotationMatrix(ist::quaternionFromRotationVector({turn(random), turn(random), turn(random)}));
	e.density *= float(b * c / (longest * longest));
	e.setShape(ist::rotated(R, {longest * longest, b * b, c * c, 0, 0, 0}));
}

/// The ellipsoid as a tree returns it.
inline ist::MomentEllipsoid asStored(const ist::MomentEllipsoid& e) { return ist::StoredEllipsoid(e).in({e.x, e.y, e.z, e.R}); }
