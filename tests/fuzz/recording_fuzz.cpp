// SPDX-License-Identifier: Zlib
// Recordings of devices. Any bytes, also with a corrected checksum, are refused, or can be written again, played to the end, and
// converted to the motion of a hand.
#include "BulletISTCollision/Core/Asset/ByteStream.h"
#include "BulletISTCollision/Core/Asset/Checksum.h"
#include "DeviceBridge/Drivers/Replay/ReplayDevice.h"
#include "DeviceBridge/Hand/HandRecording.h"

#include "tests/fuzz/Invariants.h"

#include <vector>

namespace
{
void decode(const std::vector<std::byte>& bytes)
{
	const ist::Result<devicebridge::Recording> recording = devicebridge::decodeRecording(bytes.data(), bytes.size());
	if (!fuzz::accepted(recording)) return;
	const std::vector<std::byte> again = devicebridge::encodeRecording(recording.value());
	const ist::Result<devicebridge::Recording> back = devicebridge::decodeRecording(again.data(), again.size());
	fuzz::require(fuzz::accepted(back) && devicebridge::encodeRecording(back.value()) == again, "what was read can be written and read");
	(void)fuzz::accepted(devicebridge::handMotionOf(recording.value()));

	devicebridge::ReplayDevice device(recording.value());
	(void)device.open();
	devicebridge::DeviceState state;
	devicebridge::HandState hand;
	for (std::size_t i = 0; i <= device.length(); ++i)
	{
		(void)device.read(static_cast<std::int64_t>(i), state);
		(void)device.readHand(hand);
		(void)device.write({});
	}
	fuzz::require(device.played() <= device.length(), "no more is played than there is");
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
	const auto* first = reinterpret_cast<const std::byte*>(data);
	std::vector<std::byte> bytes(first, first + size);
	decode(bytes);
	if (size < 8) return 0;
	const std::uint64_t sum = ist::checksum64(bytes.data(), size - 8);
	for (std::size_t i = 0; i < 8; ++i) bytes[size - 8 + i] = static_cast<std::byte>(sum >> (8 * i));
	decode(bytes);
	return 0;
}
