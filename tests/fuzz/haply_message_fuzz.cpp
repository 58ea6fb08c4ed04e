// SPDX-License-Identifier: Zlib
// Messages of the Haply Inverse service: an accepted message is finite, and a command to that device is a valid message again.
#include "DeviceBridge/Drivers/Haply/HaplyMessages.h"

#include "tests/fuzz/Invariants.h"

using fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
	const std::string text = fuzz::text(data, size);
	for (const char* wanted : {"", "a"})
	{
		const ist::Result<std::optional<devicebridge::HaplyState>> read = devicebridge::readHaplyMessage(text, wanted, wanted);
		if (!fuzz::accepted(read) || !read.value()) continue;
		const devicebridge::HaplyState& state = *read.value();
		require(ist::isFinite(state.position) && ist::isFinite(state.velocity), "place and velocity are finite");
		require(*wanted == 0 || state.deviceId == wanted, "the device is the one that is wanted");
		require(*wanted == 0 || !state.orientation || state.gripId == wanted, "and so is the grip");
		for (const bool values : {false, true})
			require(!devicebridge::haplyForceMessage(state.kind, state.deviceId, {1, 2, 3}, values).empty(), "it can be answered");
	}
	return 0;
}
