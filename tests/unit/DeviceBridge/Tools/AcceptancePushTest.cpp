// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Tools/AcceptancePush.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "DeviceBridge/Drivers/Simulated/SimulatedProfile.h"

using namespace devicebridge;

namespace
{
/// A handle that is swung to and fro at up to 2 m/s, and that stops to answer after `samples`.
class SwungHandle final : public Device
{
public:
	explicit SwungHandle(Clock& clock) : m_clock(clock) {}
	DeviceInfo description = simulatedProfile("sigma7").value().info;
	std::uint64_t samples = 3000, lateAt = 0;
	double strongest = 0;
	const DeviceInfo& info() const noexcept override { return description; }
	DeviceStatus open() noexcept override { return DeviceStatus::Ok; }
	void close() noexcept override {}
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override
	{
		if (++m_reads > samples) return DeviceStatus::Disconnected;
		if (m_reads == lateAt) m_clock.sleepUntil(now + 300'000'000);
		constexpr double kWay = 0.1, kRate = 20;  // [m, 1/s]
		const double phase = 1e-3 * kRate * static_cast<double>(m_reads);
		state = {};
		state.sequence = m_reads;
		state.sampledAt = now;
		state.X_WH.translation.y = -kWay * std::cos(phase);
		state.twist.linear.y = kWay * kRate * std::sin(phase);
		return DeviceStatus::Ok;
	}
	DeviceStatus write(const DeviceCommand& command) noexcept override
	{
		strongest = std::max(strongest, norm(command.wrench.force) + norm(command.wrench.torque));
		return DeviceStatus::Ok;
	}

private:
	Clock& m_clock;
	std::uint64_t m_reads = 0;
};
}  // namespace

TEST(AcceptancePush, WhileTheDeviceIsUnpluggedEveryCommandIsZero)
{
	VirtualClock clock;
	SwungHandle device(clock);
	const tools::LossOutcome loss = tools::waitForLoss(device, clock, 30);
	EXPECT_EQ(loss.cause, FaultCause::Disconnected);
	EXPECT_NEAR(loss.seconds, 3, 0.02);
	EXPECT_EQ(device.strongest, 0);
}

TEST(AcceptancePush, ALateTickIsNoLoss)
{
	VirtualClock clock;
	SwungHandle device(clock);
	device.lateAt = 500;
	const tools::LossOutcome loss = tools::waitForLoss(device, clock, 30);
	EXPECT_EQ(loss.cause, FaultCause::Disconnected);
	EXPECT_NEAR(loss.seconds, 3.3, 0.02);
	device.samples = 1'000'000;
	EXPECT_EQ(tools::waitForLoss(device, clock, 2).cause, FaultCause::None);
}
