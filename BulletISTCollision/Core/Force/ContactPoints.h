// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Faces/ContactFaces.h"
#include "BulletISTCollision/Core/Force/PressureField.h"

#include <cstddef>
#include <cstdint>

namespace ist
{
/// A point of the contact surface of two bodies: it stands for a small area of the surface of one body inside the other. In the axes of
/// A's mesh frame, relative to A's `origin`.
struct ContactPoint
{
	Vec3 position;        ///< where the pressure acts: centroid of the pressure over the area [m]
	Vec3 normal;          ///< direction of the force on A; unit length
	double area = 0;      ///< [m^2]
	double pressure = 0;  ///< force over area [Pa]
	double error = 0;     ///< standard error of the pressure [Pa]
	bool ofA = false;     ///< whether the area is of A's surface; otherwise it is of B's
	/// Extent of the area: the rectangle that has its centroid, its size and its second moments, with the half sides `sides` [m]. A flat
	/// face is one point, however large it is. Zero where the extent is not known.
	Vec3 center{}, sides[2]{};
	Vec3 slope{};  ///< gradient of the pressure along the area [Pa/m]

	Vec3 force() const { return (pressure * area) * normal; }  ///< force on A [N]
};

/// Number of points of the contact surface of an answer. 0 where leaves answered: they have no surface.
size_t contactPointCount(const OverlapResult& answer);
/// Writes the first `capacity` points of the contact surface to `points`, and returns their number. The faces of `answer` must still be in
/// its workspace. The forces of all points add up to the force of `pressureWrench(answer.total, pair)`, and position x force to its
/// torque, up to rounding. No allocation; O(points).
size_t contactPoints(const OverlapResult& answer, const PressurePair& pair, ContactPoint* points, size_t capacity);
}  // namespace ist
