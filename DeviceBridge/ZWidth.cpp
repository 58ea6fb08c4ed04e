// SPDX-License-Identifier: Zlib
#include "DeviceBridge/ZWidth.h"

#include <algorithm>
#include <cmath>

#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"

namespace devicebridge
{
namespace
{
constexpr std::int64_t kPeriod = 1'000'000;  // [ns]
constexpr int kWindow = 1500;                // ticks
constexpr double kStart = 1e-4;              // [m]

/// Whether the free handle, let go on the wall's spring, swings less in the second window than in the first.
bool decays(const SimulatedProfile& profile, double stiffness, double damping)
{
	SimulatedDevice device(profile);
	device.place({{}, {kStart, 0, 0}});
	device.open();
	DeviceState state;
	double earlier = 0, later = 0;
	for (int i = 0; i < 2 * kWindow; ++i)
	{
		device.read(i * kPeriod, state);
		const double x = state.X_WH.translation.x;
		if (!(std::fabs(x) < 1e3 * kStart)) return false;
		double& largest = i < kWindow ? earlier : later;
		largest = std::max(largest, std::fabs(x));
		DeviceCommand command;
		command.computedAt = i * kPeriod;
		command.expiresAt = command.computedAt + (kMaxDelayTicks + 2) * kPeriod;
		command.wrench.force.x = -stiffness * x - damping * state.twist.linear.x;
		device.write(command);
	}
	return later < earlier;
}
}  // namespace

std::vector<ZWidthPoint> measureZWidth(const SimulatedProfile& profile, int delayTicks, const std::vector<double>& dampings)
{
	SimulatedProfile bare = profile;
	bare.info.resolution = bare.info.angularResolution = 0;
	bare.handStiffness = bare.handDamping = 0;
	bare.velocityFromPositions = false;
	bare.delayTicks = delayTicks;
	const double T = 1e-9 * kPeriod, b = profile.damping;
	std::vector<ZWidthPoint> points;
	for (const double B : dampings)
	{
		ZWidthPoint point;
		point.damping = B;
		point.predicted = (b + B) / (T / 2 + delayTicks * T);
		point.passive = std::max(0.0, 2 * (b - B) / T);
		double low = 0, high = 4 * point.predicted;
		for (int i = 0; i < 14; ++i)
		{
			const double middle = (low + high) / 2;
			(decays(bare, middle, B) ? low : high) = middle;
		}
		point.stable = (low + high) / 2;
		points.push_back(point);
	}
	return points;
}
}  // namespace devicebridge
