// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Coupling/ZWidth.h"
#include "demos/scenes/Pages/HtmlReport.h"

#include <string>
#include <vector>

namespace scenes
{
/// Which stiffness K and damping B of a virtual wall, F = -K x - B v at 1 kHz, a device bears: the stable and the passive region, measured
/// on simulated devices without a hand, beside the closed forms.
struct ZWidthCurve
{
	int delayTicks = 0;
	bool quantised = false;
	std::vector<devicebridge::ZWidthPoint> points;
};

struct ZWidthDevice
{
	std::string profile, model;
	double mass = 0, damping = 0, resolution = 0;  ///< of handle and hand, of the mechanism, of the sensor [kg, N s/m, m]
	std::vector<ZWidthCurve> curves;
};

struct ZWidthOutcome
{
	std::vector<ZWidthDevice> devices;
	/// Largest |stable / (b + B)/(T/2 + t_d) - 1| without quantisation where (b + B)(T/2 + t_d)/m is at most 0.02, where that form holds;
	/// and how many such points.
	double stableError = 0;
	int stablePoints = 0;
	/// Largest of passive measured over 2 (b - B)/T, and over stable, all without delay and quantisation.
	double passiveOverBound = 0, passiveOverStable = 0;

	/// The measured regions are those of theory: within 5 % the stable one, inside the bound (within a millionth) the passive one.
	bool ok() const { return stablePoints > 0 && stableError <= 0.05 && passiveOverBound <= 1 + 1e-6 && passiveOverStable <= 1.02; }
};

/// `profiles` as simulatedProfile() takes them; delays in ticks. About a second for each of two curves a profile and delay.
ist::Result<ZWidthOutcome> runZWidth(const std::vector<std::string>& profiles, const std::vector<int>& delays);

std::vector<std::vector<std::string>> summaryRows(const ZWidthOutcome& outcome);
HtmlReport makeReport(const ZWidthOutcome& outcome);
std::string makeJson(const ZWidthOutcome& outcome);
}  // namespace scenes
