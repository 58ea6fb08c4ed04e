// SPDX-License-Identifier: Zlib
// A glove's calibration file and its stream, both from the same bytes.
#include "DeviceBridge/Drivers/Glove/GloveFrames.h"
#include "DeviceBridge/Drivers/Glove/GloveHand.h"

#include "tests/fuzz/HandInvariants.h"

using fuzz::require;

namespace
{
void calibration(const std::string& text)
{
	const ist::Result<devicebridge::GloveCalibration> read = devicebridge::readGloveCalibration(text);
	if (!fuzz::accepted(read)) return;
	const ist::Result<devicebridge::GloveCalibration> back = devicebridge::readGloveCalibration(writeGloveCalibration(read.value()));
	require(fuzz::accepted(back) && back.value().gain == read.value().gain && back.value().offset == read.value().offset,
		"what was read can be written and read");
}

void stream(const std::uint8_t* data, std::size_t size)
{
	for (const int wanted : {0, 18, 22})
	{
		devicebridge::GloveFrames frames(wanted);
		std::uint64_t zeros = 0, whole = 0;
		for (std::size_t i = 0; i < size; ++i)
		{
			zeros += data[i] == 0;
			if (!frames.take(data[i])) continue;
			++whole;
			require(frames.sensors() == 18 || frames.sensors() == 22, "a frame has 18 or 22 values");
			require(wanted == 0 || frames.sensors() == wanted, "a frame is of the glove that is wanted");
			fuzz::requireSound(devicebridge::gloveHand(devicebridge::roughGloveCalibration().angles(frames.values()), {}));
		}
		require(whole + frames.dropped() == zeros, "each zero ends a frame or is counted");
	}
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
	calibration(fuzz::text(data, size));
	stream(data, size);
	return 0;
}
