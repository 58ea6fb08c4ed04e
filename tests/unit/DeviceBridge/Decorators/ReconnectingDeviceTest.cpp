// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Decorators/ReconnectingDevice.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

using namespace devicebridge;

namespace
{
/// A device whose cable is a flag; opening fails while it is unplugged.
class Cable final : public Device
{
public:
	std::atomic<bool> in{true};
	std::atomic<int> openings{0}, closings{0};
	DeviceInfo description;

	const DeviceInfo& info() const noexcept override { return description; }
	DeviceStatus open() noexcept override
	{
		++openings;
		m_open = in;
		return m_open ? DeviceStatus::Ok : DeviceStatus::Disconnected;
	}
	void close() noexcept override
	{
		++closings;
		m_open = false;
	}
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override
	{
		if (!m_open || !in) return DeviceStatus::Disconnected;
		state.sampledAt = now;
		return DeviceStatus::Ok;
	}
	DeviceStatus write(const DeviceCommand&) noexcept override { return m_open && in ? DeviceStatus::Ok : DeviceStatus::Disconnected; }
	bool readHand(HandState&) noexcept override { return m_open; }
	std::string complaint() const override { return m_open ? "" : "no cable"; }

private:
	bool m_open = false;  // accessed by one thread at a time, which the thread sanitizer checks
};

template <class Condition> bool within(Condition condition, int milliseconds = 5000)
{
	for (int i = 0; i < milliseconds; ++i)
	{
		if (condition()) return true;
		std::this_thread::sleep_for(std::chrono::milliseconds(1));
	}
	return false;
}
}  // namespace

TEST(ReconnectingDevice, WaitsTwiceAsLongAfterEachFailure)
{
	const ReconnectSettings settings{50, 1000};
	const std::int64_t expected[] = {50, 100, 200, 400, 800, 1000, 1000};
	for (int i = 0; i < 7; ++i) EXPECT_EQ(reconnectDelay(settings, i), expected[i]);
	EXPECT_EQ(reconnectDelay(settings, 1000000), 1000);
}

TEST(ReconnectingDevice, OpensAgainAwayFromTheTick)
{
	auto owned = std::make_unique<Cable>();
	Cable& cable = *owned;
	ReconnectingDevice device(std::move(owned), {1'000'000, 4'000'000});
	ASSERT_EQ(device.open(), DeviceStatus::Ok);
	DeviceState state;
	EXPECT_EQ(device.read(1, state), DeviceStatus::Ok);
	for (std::uint64_t round = 1; round <= 3; ++round)
	{
		cable.in = false;
		EXPECT_EQ(device.read(2, state), DeviceStatus::Disconnected);
		const int before = cable.openings;
		EXPECT_TRUE(within([&] { return cable.openings >= before + 3; }));
		EXPECT_EQ(device.write({}), DeviceStatus::Disconnected);
		cable.in = true;
		EXPECT_TRUE(within([&] { return device.read(3, state) == DeviceStatus::Ok; }));
		EXPECT_EQ(device.reconnections(), round);
	}
	device.close();
	EXPECT_EQ(device.read(4, state), DeviceStatus::Disconnected);
}

// The thread sanitizer detects concurrent calls of the device.
TEST(ReconnectingDevice, MayBeAskedForAHandAndForAReasonWhileItIsOpened)
{
	auto owned = std::make_unique<Cable>();
	Cable& cable = *owned;
	ReconnectingDevice device(std::move(owned), {10'000, 10'000});
	ASSERT_EQ(device.open(), DeviceStatus::Ok);
	DeviceState state;
	HandState hand;
	EXPECT_TRUE(device.readHand(hand));
	cable.in = false;
	EXPECT_EQ(device.read(1, state), DeviceStatus::Disconnected);
	int reasons = 0;
	const bool tried = within([&] {
		EXPECT_FALSE(device.readHand(hand));
		reasons += device.complaint() == "no cable";
		return cable.openings > 20 && reasons > 0;
	});
	EXPECT_TRUE(tried);
	cable.in = true;
	EXPECT_TRUE(within([&] { return device.read(3, state) == DeviceStatus::Ok; }));
	EXPECT_TRUE(device.readHand(hand));
	EXPECT_EQ(device.complaint(), "");
}

TEST(ReconnectingDevice, EndsWhileTheCableIsOut)
{
	auto owned = std::make_unique<Cable>();
	Cable& cable = *owned;
	ReconnectingDevice device(std::move(owned), {3'600'000'000'000, 3'600'000'000'000});
	ASSERT_EQ(device.open(), DeviceStatus::Ok);
	cable.in = false;
	DeviceState state;
	device.read(1, state);
	std::this_thread::sleep_for(std::chrono::milliseconds(20));
	device.close();
	EXPECT_GE(cable.closings, 1);
}
