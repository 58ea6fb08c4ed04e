// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Device/Device.h"

namespace devicebridge
{
/// One read of a device and the first write after it.
struct RecordedTick
{
	std::int64_t now = 0;  ///< time that was passed to read() [ns]
	DeviceStatus readStatus = DeviceStatus::Ok, writeStatus = DeviceStatus::Ok;
	bool written = false;
	DeviceState state;      ///< state, if the read was Ok
	DeviceCommand command;  ///< command, if `written`
};

struct Recording
{
	DeviceInfo info;
	std::vector<RecordedTick> ticks;
	std::vector<HandState> hands;  ///< one for each tick if the device senses the joints of a hand, else none
	std::uint64_t dropped = 0;     ///< number of reads that were lost because the memory was full
};

constexpr std::uint32_t kRecordingVersion = 3;

/// Layout, little endian: "ISTDREC", version, device, sizes, ticks, hands, handedness, and XXH64 of everything before it. Numbers keep all
/// their bits.
std::vector<std::byte> encodeRecording(const Recording& recording);
/// Refuses other files, newer versions, and files that were cut or changed, and gives the reason. Version 1 had no hands; version 2 had no
/// handedness of the device.
ist::Result<Recording> decodeRecording(const std::byte* bytes, std::size_t size);

/// Writes the whole file or none. Returns the number of bytes.
ist::Result<std::size_t> saveRecording(const Recording& recording, const std::string& path);
ist::Result<Recording> loadRecording(const std::string& path);
}  // namespace devicebridge
