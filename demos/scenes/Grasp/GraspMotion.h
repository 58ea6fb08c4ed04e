// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Hand/HandPosture.h"

namespace scenes
{
/// A hand, palm down, whose thumb stands against its fingers: `gap` [m] between their skins, `depth` [m] below the wrist's joint, on both
/// sides of z = `middle` in the wrist's frame. What is out of reach is approached as far as it goes.
devicebridge::HandPosture pinchPosture(const devicebridge::GloveHandSize& size, double gap, double depth, double middle);

/// From 0 at `from` to 1 at `to`, at rest at both ends.
double smoothShare(double time, double from, double to);

/// A grasp from above, without a plan: approach, close, lift, turn, rest, shake, turn back, put down, let go.
struct GraspMotion
{
	devicebridge::GloveHandSize size;
	double gripX = 0, gripHeight = 0.03, gripZ = 0;  ///< where the fingers meet [m]
	double width = 0.05;                             ///< of the object [m]
	double squeeze = 0.014;                          ///< so much narrower the hand closes [m]
	double open = 0.024;                             ///< so much wider it comes [m]
	double lift = 0.12;                              ///< [m]
	double turn = 0.6;                               ///< about x, and half as much about y [rad]
	double shake = 0.015;                            ///< amplitude, along x and y [m]
	double frequency = 2;                            ///< [Hz]

	/// Ends of the phases [s].
	static constexpr double kApproached = 0.5, kClosed = 1.1, kLifted = 1.7, kTurned = 2.3, kRested = 2.6, kShaken = 3.6, kTurnedBack = 4.2,
							kPutDown = 4.9, kOpened = 5.3, kEnd = 5.7;
	devicebridge::HandPosture at(double time) const;
};
}  // namespace scenes
