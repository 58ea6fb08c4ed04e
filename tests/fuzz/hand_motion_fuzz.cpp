// SPDX-License-Identifier: Zlib
// Motions of hands as CSV: an accepted file has times that increase, and is the same to the last bit after it is written and read
// again.
#include "DeviceBridge/Hand/HandMotion.h"

#include "tests/fuzz/Invariants.h"

using fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
	const ist::Result<devicebridge::HandMotion> motion = devicebridge::readHandMotion(fuzz::text(data, size), "a.csv");
	if (!fuzz::accepted(motion)) return 0;
	const auto& frames = motion.value().frames;
	for (size_t i = 1; i < frames.size(); ++i) require(frames[i - 1].time < frames[i].time, "times grow");
	const std::string again = devicebridge::handMotionText(motion.value());
	const ist::Result<devicebridge::HandMotion> back = devicebridge::readHandMotion(again, "b.csv");
	require(fuzz::accepted(back) && back.value().frames.size() == frames.size(), "what was read can be written and read");
	for (size_t i = 0; i < frames.size(); ++i)
		require(
			back.value().frames[i].time == frames[i].time && isSameHand(back.value().frames[i].hand, frames[i].hand), "to the last bit");
	if (!frames.empty()) (void)motion.value().at(0.5 * (frames.front().time + frames.back().time));
	return 0;
}
