// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <string>

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Drivers/Glove/GloveAngles.h"

namespace devicebridge
{
/// One value of each sensor, 1 to 255, in the order of GloveSensor; zero where the glove lacks the sensor.
using GloveValues = std::array<std::uint8_t, kGloveSensors>;

/// angle = gain (value - offset) for each sensor. A distal joint without a sensor bends by two thirds of the joint before it.
struct GloveCalibration
{
	std::array<double, kGloveSensors> offset{}, gain{};  ///< [1], [rad]

	GloveAngles angles(const GloveValues& values) const noexcept;
};

/// Takes each sensor's whole span for the whole span of its joint: better than nothing, and not marked as calibrated.
GloveCalibration roughGloveCalibration();
/// From one value of each sensor with the hand flat on a table, fingers together (all angles zero), and one with the fist closed and
/// the wrist straight (bends of a quarter turn; 50 degrees at the thumb). Sensors that the two poses do not tell apart by at least 10
/// steps are refused by name, abductions, palm and wrist excepted: these keep the gain of the rough calibration and take their zero
/// from the flat hand.
ist::Result<GloveCalibration> calibrateGlove(const GloveValues& flat, const GloveValues& fist, bool hasDistal);

/// {"schema":1,"sensors":{"thumb_roll":{"offset":..,"gain":..},...}}: every sensor by name, nothing else.
ist::Result<GloveCalibration> readGloveCalibration(const std::string& text);
std::string writeGloveCalibration(const GloveCalibration& calibration);
ist::Result<GloveCalibration> loadGloveCalibration(const std::string& path);
}  // namespace devicebridge
