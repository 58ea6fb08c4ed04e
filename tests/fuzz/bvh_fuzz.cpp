// SPDX-License-Identifier: Zlib
// BVH files: an accepted file gives a hand whose joints are all finite, and times that increase.
#include "DeviceBridge/Hand/BvhHand.h"

#include "tests/fuzz/HandInvariants.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
	const std::string text = fuzz::text(data, size);
	for (const bool left : {false, true})
	{
		devicebridge::BvhHandOptions options;
		options.left = left;
		const ist::Result<devicebridge::HandMotion> motion = devicebridge::readBvhHand(text, "a.bvh", options);
		if (!fuzz::accepted(motion)) continue;
		double before = -1;
		for (const auto& frame : motion.value().frames)
		{
			fuzz::require(frame.time > before, "times grow");
			before = frame.time;
			fuzz::requireSound(frame.hand);
		}
	}
	return 0;
}
