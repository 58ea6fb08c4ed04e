// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactStore.h"

namespace devicebridge
{
/// Centroid of an overlap of a contact, in Bullet's World [m]. Its volume must be positive.
inline ist::Vec3 centroidInWorld(const btISTContact& contact, const ist::OverlapIntegrals& sums) noexcept
{
	return contact.X_WA * (contact.treeA->origin + sums.firstMoment / sums.volume);
}

/// Sum of the impulses on A in the last step, about a point. World axes [N s, N m s]. O(patches).
inline ist::Wrench impulseOnA(const btISTContact& contact, const ist::Vec3& about) noexcept
{
	ist::Wrench sum;
	for (int i = 0; i < contact.patchCount; ++i)
	{
		if (!(contact.patches[i].volume > 0)) continue;
		const ist::Wrench& onA = contact.impulses[i];
		sum.force += onA.force;
		sum.torque += onA.torque + cross(centroidInWorld(contact, contact.patches[i]) - about, onA.force);
	}
	return sum;
}
}  // namespace devicebridge
