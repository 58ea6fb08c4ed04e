// SPDX-License-Identifier: Zlib
#pragma once

#include <vector>

#include "DeviceBridge/Drivers/Simulated/SimulatedProfile.h"

namespace devicebridge
{
/// The largest stiffness that a device bears at one damping of a virtual wall, F = -K x - B v at 1 kHz, without hand and
/// quantisation.
struct ZWidthPoint
{
	double damping = 0;    ///< B of the wall [N s/m]
	double stable = 0;     ///< K at which the measured oscillation neither grows nor decays [N/m]
	double predicted = 0;  ///< (b + B) / (T / 2 + t_d), for (b + B) (T / 2 + t_d) / m far below one (Gil and Hulin) [N/m]
	double passive = 0;    ///< 2 (b - B) / T, zero where negative (Colgate and Schenkel); without delay [N/m]
};

/// One point for each damping. `delayTicks` 0 to kMaxDelayTicks.
std::vector<ZWidthPoint> measureZWidth(const SimulatedProfile& profile, int delayTicks, const std::vector<double>& dampings);
}  // namespace devicebridge
