// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Law/btContactLaw.h"

#include <cstdint>
#include <vector>

class btRigidBody;

/// What of the motion of bodies in contact is lost when Bullet rounds their poses to btScalar. A body that moves by less than half a
/// rounding in a step does not move at all, for ever: without this, dampers and half-reached equilibria would hold up what should sink, and
/// a body whose rotation is lost while its translation is not would slide although nothing slips. Here the lost parts add up. Contact takes
/// them for displacements of its own stiffness; where they come to a whole rounding, the pose takes them.
///
/// Rigid bodies only, known by their index in the world and their address. A body that was moved by anything but its velocity, or that
/// was without contact for a step, begins with nothing lost. One owner thread; allocates only in `reserve`, and for bodies beyond it.
class btCompensatedPoses
{
public:
	/// For a world of as many objects.
	void reserve(size_t bodies);
	/// Before contacts are evaluated in step `step`: the displacement that the body's pose lacks, translation of the centre of mass [m] and
	/// rotation [rad], World. Zero for a body that is not in the world. The same answer when asked again in the step.
	ist::Twist recall(const btRigidBody& body, uint64_t step);
	/// When the velocities of the step are final and not yet integrated: moves the pose by whole roundings, and remembers it. `h`: step
	/// [s].
	void settle(btRigidBody& body, double h, uint64_t step);

private:
	struct Place
	{
		const btRigidBody* body = nullptr;
		uint64_t step = 0;
		ist::Pose pose;  // from which Bullet goes on in `h` with `velocity`
		ist::Twist velocity;
		double h = 0;
		ist::Twist lacking;
	};
	Place* find(const btRigidBody& body);

	std::vector<Place> m_places;  // by index in the world
};
