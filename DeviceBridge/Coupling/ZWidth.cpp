// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Coupling/ZWidth.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"

namespace devicebridge
{
namespace
{
constexpr std::int64_t kPeriod = 1'000'000;  // [ns]
constexpr int kWindow = 1500;                // ticks
constexpr double kStart = 1e-4;              // [m]
constexpr double kTick = 1e-9 * kPeriod;     // [s]
constexpr int kLongestHalf = 256;            // half the longest motion, in ticks
constexpr double kPi = 3.14159265358979323846;

/// Start of the motion [m], many times the sensor's step, so that the steps cannot hold the handle.
double startOf(const SimulatedProfile& profile) { return std::max(kStart, 50 * profile.info.resolution); }

/// Whether the free handle, released on the wall's spring, oscillates less in the second window than in the first.
bool decays(const SimulatedProfile& profile, double stiffness, double damping)
{
	SimulatedDevice device(profile);
	const double start = startOf(profile);
	device.place({{}, {start, 0, 0}});
	device.open();
	DeviceState state;
	double earlier = 0, later = 0;
	for (int i = 0; i < 2 * kWindow; ++i)
	{
		device.read(i * kPeriod, state);
		const double x = state.X_WH.translation.x;
		if (!(std::fabs(x) < 1e3 * start)) return false;
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
/// One period of a motion of the handle, straight between ticks. It sums what the mechanism dissipates per damping, and the energy of wall
/// and hold per K and per B. The wall sees the position delayed and in steps.
class Motion
{
public:
	Motion(std::vector<double> positions, int delay, double step)
	{
		const auto n = positions.size();
		const auto seen = [&](std::size_t k) {
			const double x = positions[(k + n * (1 + static_cast<std::size_t>(delay) / n) - static_cast<std::size_t>(delay)) % n];
			return step > 0 ? step * std::round(x / step) : x;
		};
		for (std::size_t k = 0; k < n; ++k)
		{
			const double way = positions[(k + 1) % n] - positions[k];
			m_taken += way * way / kTick;
			m_spring += seen(k) * way;
			m_damper += (seen(k) - seen(k + n - 1)) / kTick * way;
		}
	}
	/// The smallest K at which the motion takes energy out; infinite if none does.
	double limit(double b, double B) const
	{
		const double left = std::max(0.0, b * m_taken + B * m_damper);
		return m_spring < 0 ? left / -m_spring : std::numeric_limits<double>::infinity();
	}

private:
	double m_taken = 0, m_spring = 0, m_damper = 0;
};

std::vector<Motion> motionsOf(int delay, double start, double step)
{
	std::vector<Motion> motions;
	for (int half = 1; half <= kLongestHalf; half = std::max(half + 1, half * 9 / 8))
	{
		std::vector<double> triangle, sine;
		for (int k = 0; k < 2 * half; ++k)
		{
			triangle.push_back(start * (1 - 2.0 * std::abs(k - half) / half));
			sine.push_back(start * std::sin(kPi * (k + 0.5) / half));
		}
		motions.emplace_back(triangle, delay, step);
		motions.emplace_back(sine, delay, step);
	}
	return motions;
}
}  // namespace

std::vector<ZWidthPoint> measureZWidth(const SimulatedProfile& profile, int delayTicks, const std::vector<double>& dampings, bool quantised)
{
	SimulatedProfile bare = profile;
	if (!quantised) bare.info.resolution = bare.info.angularResolution = 0;
	bare.handStiffness = bare.handDamping = 0;
	bare.velocityFromPositions = false;
	bare.delayTicks = delayTicks;
	const double T = kTick, b = profile.damping;
	const std::vector<Motion> motions = motionsOf(delayTicks, startOf(bare), bare.info.resolution);
	std::vector<ZWidthPoint> points;
	for (const double B : dampings)
	{
		ZWidthPoint point;
		point.damping = B;
		point.predicted = (b + B) / (T / 2 + delayTicks * T);
		point.passive = std::max(0.0, 2 * (b - B) / T);
		point.passiveMeasured = std::numeric_limits<double>::infinity();
		for (const Motion& motion : motions) point.passiveMeasured = std::min(point.passiveMeasured, motion.limit(b, B));
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
