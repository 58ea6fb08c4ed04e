// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Device/HandState.h"

#include "tests/fuzz/Invariants.h"

namespace fuzz
{
inline void requireSound(const devicebridge::HandState& hand)
{
	for (const devicebridge::HandJoint& joint : hand.joints)
		require(
			!joint.tracked || ist::isRigid({ist::rotationMatrix(joint.orientation), joint.position}), "joints that are tracked are finite");
}
}  // namespace fuzz
