// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"

#include <vector>

namespace devicebridge
{
/// A point where a hand presses on an object, in the frame of the object's centre of mass.
struct GraspContact
{
	ist::Vec3 point;            ///< [m]
	ist::Vec3 normal;           ///< unit normal into the object
	double friction = 0;        ///< Coulomb's coefficient
	double frictionRadius = 0;  ///< largest drilling moment over friction times normal force [m]; 0: a hard point contact
};

struct GraspQuality
{
	bool forceClosure = false;  ///< whether the contacts can resist a small wrench in every direction
	/// Radius of the largest ball around zero of wrenches that the contacts can resist, with normal forces whose sum is 1 N [N]. Torques
	/// are divided by `length`. Zero without force closure.
	double epsilon = 0;
	int wrenches = 0;  ///< number of corners of the friction cones
	int iterations = 0;
	bool exact = true;  ///< false: the search stopped early, and `epsilon` is the lower bound that it had reached
};

struct GraspQualityOptions
{
	double length = 0.05;  ///< length by which torques are divided [m]: about the object's largest radius
	int edges = 8;         ///< number of edges of a friction cone, which is approximated by the pyramid inside it
	int mostFacets = 200000;
};

/// The epsilon of Ferrari and Canny, Planning optimal grasps, ICRA 1992 (their L1 norm: the convex hull of the cones' corners). The hull in
/// six dimensions grows only where its surface is nearest to zero, until the nearest facet is a facet of the whole hull. Drilling friction
/// adds two corners per contact, with the largest drilling moment and no force along the surface. Contacts that are not finite are ignored.
/// Offline: takes milliseconds, allocates.
GraspQuality graspQuality(const std::vector<GraspContact>& contacts, const GraspQualityOptions& options = {});
}  // namespace devicebridge
