// SPDX-License-Identifier: Zlib
#pragma once

#include <vector>

#include "DeviceBridge/Loop/WorldMirror.h"

#include "LinearMath/btAlignedObjectArray.h"
#include "LinearMath/btMatrix3x3.h"

class btMultiBodyLinkCollider;

namespace devicebridge
{
/// How links of multibodies move and respond at the origins of their colliders. Not installed.
class BulletLinks
{
public:
	/// Fills twist, inverse mass and inverse inertia of `out`, whose pose is set. The two inverses bound the response of the link as a part
	/// of its multibody from above, whatever the direction, because a copy that yields more than its body creates no energy. Joints that
	/// move freely are in it, motors and limits are not. Before the first step of the multibody the link does not move.
	void describe(const btMultiBodyLinkCollider& link, MirroredBody& out);
	/// Velocity at the origin of the collider, in World; zero while the multibody sleeps.
	ist::Twist twistOf(const btMultiBodyLinkCollider& link);
	/// Mass of the link itself [kg].
	static double massOf(const btMultiBodyLinkCollider& link);
	/// Adds a force and a torque about the origin of the collider, for the next step.
	static void push(const btMultiBodyLinkCollider& link, const ist::Wrench& wrench);

private:
	std::vector<btScalar> m_jacobian, m_response;  // six rows of J (force, then moment), and of M^-1 J^T
	btAlignedObjectArray<btScalar> m_scratch;
	btAlignedObjectArray<btVector3> m_scratchVectors;
	btAlignedObjectArray<btMatrix3x3> m_scratchMatrices;
};
}  // namespace devicebridge
