// SPDX-License-Identifier: Zlib
#pragma once

#include <array>

namespace devicebridge
{
/// The sensors of a 22-sensor glove, in the order in which it sends them. An 18-sensor glove lacks the four distal joints.
enum GloveSensor
{
	kThumbRoll,
	kThumbMetacarpalBend,
	kThumbBend,
	kThumbAbduction,
	kIndexKnuckle,
	kIndexMiddle,
	kIndexEnd,
	kMiddleKnuckle,
	kMiddleMiddle,
	kMiddleEnd,
	kMiddleIndexAbduction,
	kRingKnuckle,
	kRingMiddle,
	kRingEnd,
	kRingMiddleAbduction,
	kLittleKnuckle,
	kLittleMiddle,
	kLittleEnd,
	kLittleRingAbduction,
	kPalmArch,
	kWristPitch,
	kWristYaw,
	kGloveSensors
};

/// Angles of the joints [rad]. Bends are positive towards the palm and abductions positive apart. The wrist's angles are positive towards
/// the palm and towards the thumb.
using GloveAngles = std::array<double, kGloveSensors>;

constexpr bool isDistal(int sensor) { return sensor == kIndexEnd || sensor == kMiddleEnd || sensor == kRingEnd || sensor == kLittleEnd; }
}  // namespace devicebridge
