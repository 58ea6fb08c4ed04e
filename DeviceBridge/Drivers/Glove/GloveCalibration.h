// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <string>

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Drivers/Glove/GloveAngles.h"

namespace devicebridge
{
/// One value for each sensor, 1 to 255, in the order of GloveSensor; zero if the glove lacks the sensor.
using GloveValues = std::array<std::uint8_t, kGloveSensors>;

/// Calibration: angle = gain (value - offset) for each sensor. A distal joint without a sensor bends by two thirds of the joint before it.
struct GloveCalibration
{
	std::array<double, kGloveSensors> offset{}, gain{};  ///< offset [1] and gain [rad]

	GloveAngles angles(const GloveValues& values) const noexcept;
};

/// A calibration that maps each sensor's whole range to the whole range of its joint. It is better than none, and is not marked as
/// calibrated.
GloveCalibration roughGloveCalibration();
/// Calibrates from one value of each sensor in each of two poses. `flat`: the hand flat on a table, fingers together (all angles zero).
/// `fist`: the fist closed and the wrist straight (bends of 90 degrees; 60 at the distal joints, 50 at the thumb). A sensor whose two
/// values differ by less than 10 steps is refused by name. Abductions, palm and wrist are exceptions: they keep the gain of the rough
/// calibration and take their zero from the flat hand.
ist::Result<GloveCalibration> calibrateGlove(const GloveValues& flat, const GloveValues& fist, bool hasDistal);

/// Format: {"schema":1,"sensors":{"thumb_roll":{"offset":..,"gain":..},...}}, with every sensor by name and nothing else.
ist::Result<GloveCalibration> readGloveCalibration(const std::string& text);
std::string writeGloveCalibration(const GloveCalibration& calibration);
ist::Result<GloveCalibration> loadGloveCalibration(const std::string& path);
}  // namespace devicebridge
