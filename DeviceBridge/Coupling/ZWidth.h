// SPDX-License-Identifier: Zlib
#pragma once

#include <vector>

#include "DeviceBridge/Drivers/Simulated/SimulatedProfile.h"

namespace devicebridge
{
/// Largest stiffness that a device bears for one damping of a virtual wall, F = -K x - B v at 1 kHz, without a hand.
struct ZWidthPoint
{
	double damping = 0;    ///< B of the wall [N s/m]
	double stable = 0;     ///< K at which the measured oscillation neither grows nor decays [N/m]
	double predicted = 0;  ///< (b + B) / (T / 2 + t_d), for (b + B) (T / 2 + t_d) / m far below one (Gil and Hulin) [N/m]
	double passive = 0;    ///< 2 (b - B) / T, zero if negative (Colgate and Schenkel); without delay and quantisation [N/m]
	/// K at which the first of a set of motions (triangles and sines of 2 to 458 ticks) takes energy out of wall and mechanism [N/m]. The
	/// wall's velocity is the difference of two samples. It is an upper bound of the passive stiffness, and exact without delay and
	/// quantisation.
	double passiveMeasured = 0;
};

/// Returns one point for each damping. `delayTicks` is 0 to kMaxDelayTicks. `quantised`: positions have the step of the device's
/// resolution.
std::vector<ZWidthPoint> measureZWidth(
	const SimulatedProfile& profile, int delayTicks, const std::vector<double>& dampings, bool quantised = false);
}  // namespace devicebridge
