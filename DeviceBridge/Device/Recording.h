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
	std::int64_t now = 0;  ///< as read() was told [ns]
	DeviceStatus readStatus = DeviceStatus::Ok, writeStatus = DeviceStatus::Ok;
	bool written = false;
	DeviceState state;      ///< of a read that was Ok
	DeviceCommand command;  ///< of a tick that was written
};

struct Recording
{
	DeviceInfo info;
	std::vector<RecordedTick> ticks;
	std::vector<HandState> hands;  ///< one for each tick where the device senses the joints of a hand, else none
	std::uint64_t dropped = 0;     ///< reads for which there was no room
};

constexpr std::uint32_t kRecordingVersion = 3;

/// Little endian: "ISTDREC", version, the device, sizes, the ticks, the hands, whose hand it is, and XXH64 of all that stands before.
/// Numbers to the last bit.
std::vector<std::byte> encodeRecording(const Recording& recording);
/// Refuses, with the reason: other files, newer versions, cut and changed ones. Version 1 knew no hands, 2 not whether a device is for the
/// left or the right one.
ist::Result<Recording> decodeRecording(const std::byte* bytes, std::size_t size);

/// The whole file or none; gives the number of bytes.
ist::Result<std::size_t> saveRecording(const Recording& recording, const std::string& path);
ist::Result<Recording> loadRecording(const std::string& path);
}  // namespace devicebridge
