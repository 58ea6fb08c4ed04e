// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Law/btContactLaw.h"

#include <cstdint>
#include <vector>

class btRigidBody;

/// Compensated summation for the poses of bodies in contact: it keeps the motion that is lost when Bullet rounds poses to btScalar. A
/// body that moves by less than half a rounding in a step would otherwise never move. Dampers and half-reached equilibria would then hold
/// up what should sink. A body whose rotation is lost while its translation is not would slide although nothing slips.
///
/// The lost parts add up here. Contact treats them as displacements of its own stiffness. As soon as they amount to a whole rounding,
/// they are added to the pose.
///
/// Only rigid bodies are covered, identified by their index in the world and their address. The lost part is reset to zero for a body
/// that was moved by anything but its velocity, or that had no contact for a step. Only the thread of the world may use it. It allocates
/// only in `reserve`, and for bodies beyond the reserved number.
class btCompensatedPoses
{
public:
	/// Reserves memory for a world of so many objects.
	void reserve(size_t bodies);
	/// Returns the displacement that the body's pose lacks: translation of the centre of mass [m] and rotation [rad], World. Call it
	/// before contacts are evaluated in step `step`. Zero for a body that is not in the world. A second call in the same step gives the
	/// same answer.
	ist::Twist recall(const btRigidBody& body, uint64_t step);
	/// Takes back the motion of the last `time` [s] of this step of `h` [s]. Call it after `recall` and before `settle`, with the final
	/// velocities.
	void takeBack(const btRigidBody& body, double time, double h, uint64_t step);
	/// Moves the pose by whole roundings and remembers it. Call it when the velocities of the step are final and not yet integrated. `h`
	/// is the step [s].
	void settle(btRigidBody& body, double h, uint64_t step);

private:
	struct Place
	{
		const btRigidBody* body = nullptr;
		uint64_t step = 0;
		ist::Pose pose;  // pose from which Bullet continues for `h` with `velocity`
		ist::Twist velocity;
		double h = 0;
		ist::Twist lacking;
	};
	Place* find(const btRigidBody& body);

	std::vector<Place> m_places;  // one for each index in the world
};
