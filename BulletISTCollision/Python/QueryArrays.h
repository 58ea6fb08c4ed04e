// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "BulletISTCollision/Python/MeshArguments.h"

#include <optional>

namespace ist::python
{
/// One pose or many of B's mesh frame in A's: (7) or (n, 7) numbers tx ty tz qx qy qz qw, (4, 4) or (n, 4, 4) matrices, or PyBullet's
/// pair (position, quaternion). Raises a ValueError that names the row if a value is not a pose.
struct Poses
{
	std::vector<Pose> X_AB;
	bool single = false;
};
Poses posesFrom(const pybind11::object& object);

/// Returns a dict of arrays with a row for each pose, or of scalars and vectors for a single pose. Names and meanings are those of `ist
/// query --json`, with NaN for null. The law is the pressure field law with weights 1/2. With an error, each pose is answered
/// independently by `queryWithTolerance`.
pybind11::dict query(const InnerSphereTree& A, const InnerSphereTree& B, const pybind11::object& poses, double stiffness, int level,
	int64_t maxPairs, std::optional<double> error);

/// Returns the contact surface at one pose (ContactPoints.h) as a dict of arrays with a row for each point: position (n, 3) in A's mesh
/// frame, normal (n, 3), area, pressure, error and of_a. The weights are 1/2.
pybind11::dict contactSurface(const InnerSphereTree& A, const InnerSphereTree& B, const pybind11::object& pose, double stiffness);

/// The (upper, lower) bounds of the distance [m], each with a row for each pose.
pybind11::tuple distance(const InnerSphereTree& A, const InnerSphereTree& B, const pybind11::object& poses);

/// Pose X_AB of world poses X_WA and X_WB, as (7) numbers.
pybind11::array_t<double> relativePose(const pybind11::object& X_WA, const pybind11::object& X_WB);
}  // namespace ist::python
