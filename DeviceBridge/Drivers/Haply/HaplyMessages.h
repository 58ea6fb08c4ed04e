// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Base/Result.h"

namespace devicebridge
{
/// What a message of the Haply Inverse service says of one device, and of a grip: the service does not say which grip is on which device.
struct HaplyState
{
	std::string deviceId, kind;  ///< "inverse3", "inverse3x" or "minverse"
	ist::Vec3 position, velocity;
	std::string gripId;  ///< of the grip that the orientation is of
	std::optional<ist::Quaternion> orientation;
	std::uint32_t buttons = 0;
};

/// The device `wanted`, or the first one where that is empty, with the grip `grip`, or the first one that has an orientation. Nothing when
/// the message holds none; an error, in a sentence, when it is no message of the service.
ist::Result<std::optional<HaplyState>> readHaplyMessage(const std::string& text, const std::string& wanted, const std::string& grip = {});
/// The command of one tick. Services before 3.5 call the vector "values".
std::string haplyForceMessage(const std::string& kind, const std::string& deviceId, const ist::Vec3& force, bool valuesForVector);
}  // namespace devicebridge
