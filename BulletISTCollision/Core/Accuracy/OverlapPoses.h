// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/OverlapQuery.h"

#include <optional>
#include <random>

namespace ist
{
/// Overlaps at which accuracy is measured and stated, as shares of the smaller body's volume: from a touch to deep contact.
inline constexpr double kOverlapsOfContact[] = {0.001, 0.003, 0.01, 0.03, 0.1, 0.2};

/// Rotation of B, and the direction in which it then leaves A: a unit vector in A's mesh frame.
struct Departure
{
	Mat3 rotation;
	Vec3 direction;
};
Departure randomDeparture(std::mt19937_64& random);

/// The pose X_AB (mesh frames) along a departure at which the overlap is `fraction` of the smaller body's volume, measured with `level`
/// of the pair. B starts with its centre of mass at that of A and moves away by bisection. Empty if the overlap is smaller even there.
std::optional<Pose> poseAtOverlap(
	const InnerSphereTree& A, const InnerSphereTree& B, double fraction, int level, const Departure& departure, QueryWorkspace& workspace);
/// Searches like the function above, along a random departure. The result depends only on the state of `random` and the two bodies.
std::optional<Pose> poseAtOverlap(
	const InnerSphereTree& A, const InnerSphereTree& B, double fraction, int level, std::mt19937_64& random, QueryWorkspace& workspace);
}  // namespace ist
