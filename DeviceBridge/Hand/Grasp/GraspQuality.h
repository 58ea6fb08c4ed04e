// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"

#include <vector>

namespace devicebridge
{
/// A place where a hand presses on an object, in the frame of the object's centre of mass.
struct GraspContact
{
	ist::Vec3 point;            ///< [m]
	ist::Vec3 normal;           ///< into the object, unit length
	double friction = 0;        ///< Coulomb
	double frictionRadius = 0;  ///< largest drilling moment over friction times normal force [m]; 0: a hard point
};

struct GraspQuality
{
	bool forceClosure = false;  ///< the contacts can resist a small wrench in every direction
	/// Radius of the largest ball around zero of wrenches that the contacts can resist with normal forces that sum to 1 N; torques over
	/// `length`. Zero without force closure [N].
	double epsilon = 0;
	int wrenches = 0;  ///< corners of the cones
	int iterations = 0;
	bool exact = true;  ///< false: stopped early, and `epsilon` is the bound from below that was reached
};

struct GraspQualityOptions
{
	double length = 0.05;  ///< that torques are divided by: about the object's largest radius [m]
	int edges = 8;         ///< of a friction cone, which is taken for the pyramid inside of it
	int mostFacets = 200000;
};

/// The epsilon of Ferrari and Canny, Planning optimal grasps, ICRA 1992 (their L1 norm: the convex hull of the cones' corners). The hull in
/// six dimensions is grown only where its surface is nearest to zero, until the nearest facet is one of the whole. Drilling friction adds
/// two corners a contact, which stand for it without force along the surface. Contacts that are not finite count for nothing. Offline:
/// milliseconds, allocates.
GraspQuality graspQuality(const std::vector<GraspContact>& contacts, const GraspQualityOptions& options = {});
}  // namespace devicebridge
