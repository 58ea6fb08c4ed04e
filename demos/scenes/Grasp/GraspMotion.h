// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Hand/HandPosture.h"

namespace scenes
{
/// Posture of a hand, palm down, whose thumb is opposite its fingers. `gap` [m] is the distance of their skins, on both sides of z =
/// `middle` in the wrist's frame, at `depth` [m] below the wrist's joint. If a finger cannot reach its place, it goes as far as it can.
devicebridge::HandPosture pinchPosture(const devicebridge::GloveHandSize& size, double gap, double depth, double middle);

/// Smooth step from 0 at `from` to 1 at `to`, with zero slope at both ends.
double smoothShare(double time, double from, double to);

/// A scripted grasp from above: approach, close, lift, turn, rest, shake, turn back, put down, release.
struct GraspMotion
{
	devicebridge::GloveHandSize size;
	double gripX = 0, gripHeight = 0.03, gripZ = 0;  ///< point where the fingers meet [m]
	double width = 0.05;                             ///< width of the object [m]
	double squeeze = 0.014;                          ///< how much narrower than the object the hand closes [m]
	double open = 0.024;                             ///< how much wider than the object the open hand is [m]
	double lift = 0.12;                              ///< height of the lift [m]
	double turn = 0.6;                               ///< rotation about x, and half of it about y [rad]
	double shake = 0.015;                            ///< amplitude of the shaking along x and y [m]
	double frequency = 2;                            ///< [Hz]

	/// Ends of the phases [s].
	static constexpr double kApproached = 0.5, kClosed = 1.1, kLifted = 1.7, kTurned = 2.3, kRested = 2.6, kShaken = 3.6, kTurnedBack = 4.2,
							kPutDown = 4.9, kOpened = 5.3, kEnd = 5.7;
	devicebridge::HandPosture at(double time) const;
};
}  // namespace scenes
