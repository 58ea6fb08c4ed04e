// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/OverlapQuery.h"

#include <optional>
#include <random>

namespace ist
{
/// Shares of the smaller body's volume at which accuracy is measured and promised: from a touch to deep contact.
inline constexpr double kOverlapsOfContact[] = {0.001, 0.003, 0.01, 0.03, 0.1, 0.2};

/// How B is turned, and which way it then leaves A: a rotation, and a unit vector in A's mesh frame.
struct Departure
{
	Mat3 rotation;
	Vec3 direction;
};
Departure randomDeparture(std::mt19937_64& random);

/// The pose X_AB (mesh frames) on the way of a departure that overlaps by `fraction` of the smaller body's volume, as `level` of the pair
/// measures it: B begins with its centre of mass on A's and moves away by bisection. None when not even the beginning overlaps so much.
std::optional<Pose> poseAtOverlap(
	const InnerSphereTree& A, const InnerSphereTree& B, double fraction, int level, const Departure& departure, QueryWorkspace& workspace);
/// Of a random departure. The same for a state of `random` and two bodies.
std::optional<Pose> poseAtOverlap(
	const InnerSphereTree& A, const InnerSphereTree& B, double fraction, int level, std::mt19937_64& random, QueryWorkspace& workspace);
}  // namespace ist
