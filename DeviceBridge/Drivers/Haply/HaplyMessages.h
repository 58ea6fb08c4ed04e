// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Base/Result.h"

namespace devicebridge
{
/// Content of one message of the Haply Inverse service for one device and one grip. The service does not say which grip is on which device.
struct HaplyState
{
	std::string deviceId, kind;  ///< "inverse3", "inverse3x" or "minverse"
	ist::Vec3 position, velocity;
	std::string gripId;  ///< id of the grip that has the orientation
	std::optional<ist::Quaternion> orientation;
	std::uint32_t buttons = 0;
};

/// Reads the device `wanted` (empty: the first) with the grip `grip` (empty: the first that has an orientation). Returns an empty value if
/// the message contains no such device. Returns an error sentence if the text is not a message of the service.
ist::Result<std::optional<HaplyState>> readHaplyMessage(const std::string& text, const std::string& wanted, const std::string& grip = {});
/// The message for the command of one tick. Services before 3.5 call the vector "values".
std::string haplyForceMessage(const std::string& kind, const std::string& deviceId, const ist::Vec3& force, bool valuesForVector);
}  // namespace devicebridge
