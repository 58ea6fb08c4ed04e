// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"

namespace devicebridge
{
/// One patch of contact between A and B as a linear model about the poses in which it was found, in World axes. Wrench, stiffness and
/// damping are about `point` and act on A; B receives the opposite there.
struct LinearContact
{
	static constexpr int kFixed = -1, kTool = -2;  ///< values of `a` and `b` that replace a slot
	int a = kFixed, b = kFixed;
	std::uint64_t epoch = 0;                        ///< epoch of the body in slot `b`, if A is the tool
	ist::Vec3 point, normal;                        ///< centroid [m]; direction of the elastic force on A
	ist::Wrench wrench;                             ///< elastic wrench [N, N m]
	ist::SymmetricMatrix6 stiffness, damping;       ///< as in btContactPatch
	double frictionRadius = 0, frictionFactor = 1;  ///< as in btContactPatch
	double friction = 0;                            ///< Coulomb's coefficient of the pair
	ist::Pose X_WA, X_WB;                           ///< poses in which the contact was found
	double volume = 0;                              ///< overlap volume [m^3]
	int pairs = 0;                                  ///< number of pairs of leaves
	int pair = 0;                                   ///< index of the pair of parts in the snapshot from which it was found
	double restDepth = 0;                           ///< mean depth at which the contact shall rest [m]; 0: its stiffness was set
};

/// Changes the stiffness of a contact by `factor`.
inline void multiply(LinearContact& c, double factor) noexcept
{
	c.wrench = factor * c.wrench;
	for (double& k : c.stiffness.m) k *= factor;
	for (double& d : c.damping.m) d *= factor;
}

/// Motion of A and B since a contact between them was found.
struct ContactMotion
{
	ist::Pose X_WA, X_WB;  ///< present poses
	ist::Pose A, B;        ///< motions that map a point of each body from its old to its present place
	ist::Vec3 turn;        ///< rotation of A relative to B [rad]

	ContactMotion(const LinearContact& found, const ist::Pose& nowA, const ist::Pose& nowB) noexcept
		: X_WA(nowA),
		  X_WB(nowB),
		  A(nowA * inverse(found.X_WA)),
		  B(nowB * inverse(found.X_WB)),
		  turn(turnOf(A) - turnOf(B))
	{}

private:
	static ist::Vec3 turnOf(const ist::Pose& X) noexcept { return rotationVector(ist::quaternion(X.rotation)); }
};

/// The same contact after that motion. The point is the mean of its images on both bodies. The wrench decreases by the stiffness times the
/// displacement and rotation of A relative to B. `way`, if given, receives the length of that displacement [m].
inline LinearContact movedTo(const LinearContact& c, const ContactMotion& motion, double* way = nullptr) noexcept
{
	const ist::Vec3 onA = motion.A * c.point, onB = motion.B * c.point, shift = onA - onB;
	const double displacement[6] = {shift.x, shift.y, shift.z, motion.turn.x, motion.turn.y, motion.turn.z};
	LinearContact moved = c;
	moved.point = 0.5 * (onA + onB);
	moved.X_WA = motion.X_WA;
	moved.X_WB = motion.X_WB;
	for (int i = 0; i < 6; ++i)
		for (int j = 0; j < 6; ++j) (i < 3 ? moved.wrench.force[i] : moved.wrench.torque[i - 3]) -= c.stiffness(i, j) * displacement[j];
	if (way) *way = norm(shift);
	return moved;
}
inline LinearContact movedTo(const LinearContact& c, const ist::Pose& X_WA, const ist::Pose& X_WB, double* way = nullptr) noexcept
{
	return movedTo(c, ContactMotion(c, X_WA, X_WB), way);
}
}  // namespace devicebridge
