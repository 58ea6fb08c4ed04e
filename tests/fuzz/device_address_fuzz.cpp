// SPDX-License-Identifier: Zlib
// The part of a device's address after its scheme, and a pose on the command line.
#include "BulletISTCollision/Tools/PoseRows.h"
#include "DeviceBridge/Device/DeviceAddress.h"

#include "tests/fuzz/Invariants.h"

using fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
	const std::string text = fuzz::text(data, size);
	devicebridge::DeviceAddress address(text);
	require(address.path().size() <= text.size(), "the path is part of the address");
	const devicebridge::DeviceAddress again(address.rest());
	require(again.path() == address.path() && again.leftOver() == address.leftOver(), "what was read can be written and read");
	const ist::Result<double> number = address.takeNumber("rate", 5, 1, 1000);
	if (fuzz::accepted(number)) require(number.value() >= 1 && number.value() <= 1000, "a number is within its bounds");
	require(!address.take("rate"), "an option is taken once");

	const ist::tools::PoseRow row = ist::tools::parsePose(text);
	require(!row.error.empty() || ist::isFinite(row.pose.translation), "a pose is finite");
	return 0;
}
