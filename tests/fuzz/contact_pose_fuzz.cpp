// SPDX-License-Identifier: Zlib
// ContactPose's annotations: an accepted file has hands with finite joints.
#include "DeviceBridge/Hand/ContactPoseHands.h"

#include "tests/fuzz/HandInvariants.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
	const ist::Result<devicebridge::ContactPoseHands> hands = devicebridge::readContactPose(fuzz::text(data, size), "a.json");
	if (!fuzz::accepted(hands)) return 0;
	for (const auto& hand : {hands.value().left, hands.value().right})
		if (hand) fuzz::requireSound(*hand);
	return 0;
}
