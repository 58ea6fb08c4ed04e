// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Coupling/ZWidth.h"
#include "demos/scenes/Pages/HtmlReport.h"

#include <string>
#include <vector>

namespace scenes
{
/// Stiffness K and damping B of a virtual wall, F = -K x - B v at 1 kHz, that a device can render. The stable and the passive region are
/// measured on simulated devices without a hand, and compared with the closed forms.
struct ZWidthCurve
{
	int delayTicks = 0;
	bool quantised = false;
	std::vector<devicebridge::ZWidthPoint> points;
};

struct ZWidthDevice
{
	std::string profile, model;
	/// mass of handle and hand, damping of the mechanism, resolution of the sensor [kg, N s/m, m]
	double mass = 0, damping = 0, resolution = 0;
	std::vector<ZWidthCurve> curves;
};

struct ZWidthOutcome
{
	std::vector<ZWidthDevice> devices;
	/// Largest |stable / (b + B)/(T/2 + t_d) - 1| without quantisation, over the points where the closed form holds: (b + B)(T/2 + t_d)/m
	/// is at most 0.02. `stablePoints` is the number of these points.
	double stableError = 0;
	int stablePoints = 0;
	/// Largest measured passive stiffness, divided by 2 (b - B)/T and by the stable one. All without delay and quantisation.
	double passiveOverBound = 0, passiveOverStable = 0;

	/// True when the measured regions agree with theory: the stable one within 5 %, and the passive one inside its bound (within 1e-6).
	bool ok() const { return stablePoints > 0 && stableError <= 0.05 && passiveOverBound <= 1 + 1e-6 && passiveOverStable <= 1.02; }
};

/// Measures the regions. `profiles` are names for simulatedProfile(); `delays` are in ticks. Cost: one second for each of two curves a
/// profile and delay.
ist::Result<ZWidthOutcome> runZWidth(const std::vector<std::string>& profiles, const std::vector<int>& delays);

std::vector<std::vector<std::string>> summaryRows(const ZWidthOutcome& outcome);
HtmlReport makeReport(const ZWidthOutcome& outcome);
std::string makeJson(const ZWidthOutcome& outcome);
}  // namespace scenes
