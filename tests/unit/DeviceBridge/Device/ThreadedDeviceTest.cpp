// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Device/ThreadedDevice.h"

#include <atomic>
#include <thread>

#include "DeviceBridge/Decorators/ReconnectingDevice.h"
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/DeviceBridge/Drivers/DriverRun.h"

using namespace devicebridge;

namespace
{
/// State shared by a test and its link, because the link may outlive the device.
struct Bench
{
	enum class Mood
	{
		Good,
		Silent,   // present, but without samples
		Pulled,   // cable unplugged
		Hanging,  // call that does not return
		Absent    // device that is not found
	};
	std::atomic<Mood> mood{Mood::Good};
	std::atomic<int> connections{0}, disconnections{0}, samples{0};
	std::atomic<double> exerted{0};
	std::atomic<std::thread::id> owner{};
	std::atomic<bool> foreignCall{false};
};

class BenchLink final : public DeviceLink
{
public:
	explicit BenchLink(std::shared_ptr<Bench> bench) : m_bench(std::move(bench)) {}

	ist::Result<DeviceInfo> connect() noexcept override
	{
		m_bench->owner = std::this_thread::get_id();
		if (m_bench->mood == Bench::Mood::Absent) return ist::Error{"plug it in", false};
		++m_bench->connections;
		DeviceInfo info;
		info.sensed = info.actuated = kTranslation | kRotation;
		info.sensed |= kHandJointsSensed;
		info.peakForce = info.continuousForce = 5;
		info.peakTorque = info.continuousTorque = 1;
		return info;
	}
	Event exchange(const DeviceCommand& command, DeviceSample& sample) noexcept override
	{
		check();
		while (m_bench->mood == Bench::Mood::Hanging) std::this_thread::sleep_for(std::chrono::milliseconds(1));
		if (m_bench->mood == Bench::Mood::Pulled) return Event::Lost;
		m_bench->exerted = command.wrench.force.z;
		std::this_thread::sleep_for(std::chrono::microseconds(500));
		if (m_bench->mood == Bench::Mood::Silent) return Event::Nothing;
		const int n = ++m_bench->samples;
		sample.state.X_WH.translation.x = 1e-6 * n;
		sample.state.twist.linear.x = 1e-6 * n;
		sample.hand.joints[kIndexTip].position.x = 1e-6 * n;
		return Event::Sample;
	}
	void disconnect() noexcept override
	{
		check();
		++m_bench->disconnections;
		m_bench->exerted = 0;
	}
	std::string complaint() const override
	{
		std::this_thread::sleep_for(std::chrono::milliseconds(50));  // time in which a reader could see the loss before the reason
		return "the cable is out";
	}

private:
	void check()
	{
		if (m_bench->owner.load() != std::this_thread::get_id()) m_bench->foreignCall = true;
	}
	std::shared_ptr<Bench> m_bench;
};

struct Rig
{
	std::shared_ptr<Bench> bench = std::make_shared<Bench>();
	ThreadedDevice device{std::make_unique<BenchLink>(bench)};
	RealClock clock;
	DeviceState state;
	DeviceStatus read() { return device.read(clock.now(), state); }
};

DeviceCommand pushing(double force, std::int64_t now, std::int64_t life)
{
	DeviceCommand command;
	command.computedAt = now;
	command.expiresAt = now + life;
	command.wrench.force.z = force;
	return command;
}
}  // namespace

TEST(ThreadedDevice, SamplesAndHandBelongTogetherAndNeverGetOlder)
{
	Rig rig;
	ASSERT_EQ(rig.device.open(), DeviceStatus::Ok);
	std::uint64_t last = 0;
	std::int64_t lastTime = 0;
	for (int i = 0; i < 3000; ++i)
	{
		ASSERT_EQ(rig.read(), DeviceStatus::Ok);
		HandState hand;
		ASSERT_TRUE(rig.device.readHand(hand));
		EXPECT_EQ(rig.state.X_WH.translation.x, hand.joints[kIndexTip].position.x);
		EXPECT_EQ(rig.state.twist.linear.x, 1e-6 * static_cast<double>(rig.state.sequence));
		EXPECT_GE(rig.state.sequence, last);
		EXPECT_GE(rig.state.sampledAt, lastTime);
		EXPECT_LE(rig.state.sampledAt, rig.clock.now());
		last = rig.state.sequence;
		lastTime = rig.state.sampledAt;
		std::this_thread::sleep_for(std::chrono::microseconds(50));
	}
	EXPECT_GT(last, 10U);
	rig.device.close();
	EXPECT_EQ(rig.bench->disconnections, 1);
	EXPECT_FALSE(rig.bench->foreignCall);
}

TEST(ThreadedDevice, TimesFollowTheCallersClock)
{
	Rig rig;
	VirtualClock clock;
	ASSERT_EQ(rig.device.open(), DeviceStatus::Ok);
	for (int i = 0; i < 50; ++i)
	{
		clock.sleepUntil(clock.now() + 1'000'000);
		ASSERT_EQ(rig.device.read(clock.now(), rig.state), DeviceStatus::Ok);
		EXPECT_LE(rig.state.sampledAt, clock.now());
	}
	// A command on a clock that has just started lives as long as on any other.
	EXPECT_TRUE(within([&] {
		EXPECT_EQ(rig.device.write(pushing(2, clock.now(), 500'000'000)), DeviceStatus::Ok);
		return rig.bench->exerted == 2;
	}));
}

TEST(ThreadedDevice, LetsGoWhenTheCommandExpiresAndNobodyCalls)
{
	Rig rig;
	ASSERT_EQ(rig.device.open(), DeviceStatus::Ok);
	ASSERT_TRUE(within([&] {
		rig.read();
		rig.device.write(pushing(3, rig.clock.now(), 400'000'000));
		return rig.bench->exerted == 3;
	}));
	EXPECT_TRUE(within([&] { return rig.bench->exerted == 0; }));
	EXPECT_EQ(rig.device.write(pushing(std::nan(""), rig.clock.now(), 1'000'000)), DeviceStatus::Refused);
	rig.device.write(pushing(3, rig.clock.now(), -1'000'000));
	const int before = rig.bench->samples;
	EXPECT_TRUE(within([&] { return rig.bench->samples > before + 5; }));
	EXPECT_EQ(rig.bench->exerted, 0);
}

TEST(ThreadedDevice, NothingIsAllocatedByTheTick)
{
	Rig rig;
	ASSERT_EQ(rig.device.open(), DeviceStatus::Ok);
	HandState hand;
	const long before = allocationCount();
	for (int i = 0; i < 200; ++i)
	{
		rig.read();
		rig.device.readHand(hand);
		rig.device.write(pushing(1, rig.clock.now(), 20'000'000));
		std::this_thread::sleep_for(std::chrono::microseconds(100));
	}
	EXPECT_EQ(allocationCount(), before);
}

TEST(ThreadedDevice, APulledCableEndsTheForceAndIsExplained)
{
	Rig rig;
	ASSERT_EQ(rig.device.open(), DeviceStatus::Ok);
	DriverRun run(rig.device);
	run.expectLossIsSafe(rig.device, [&] { rig.bench->mood = Bench::Mood::Pulled; });
	EXPECT_EQ(rig.device.complaint(), "the cable is out");
	EXPECT_EQ(rig.bench->exerted, 0);
}

TEST(ThreadedDevice, ADeviceWithoutNewsIsFrozen)
{
	Rig rig;
	ASSERT_EQ(rig.device.open(), DeviceStatus::Ok);
	DriverRun run(rig.device);
	ASSERT_TRUE(run.until([&] { return run.force() > 0; }));
	rig.bench->mood = Bench::Mood::Silent;
	EXPECT_TRUE(run.until([&] { return run.thread().faultCause() == FaultCause::Frozen; }));
	EXPECT_EQ(run.force(), 0);
	EXPECT_TRUE(within([&] { return rig.bench->exerted == 0; }));
}

TEST(ThreadedDevice, ACallThatNeverEndsHoldsNobodyUp)
{
	Rig rig;
	ASSERT_EQ(rig.device.open(), DeviceStatus::Ok);
	rig.bench->mood = Bench::Mood::Hanging;
	rig.device.close();
	EXPECT_NE(rig.device.complaint().find("not come back"), std::string::npos);
	EXPECT_EQ(rig.read(), DeviceStatus::NotOpen);
	rig.bench->mood = Bench::Mood::Good;
	EXPECT_TRUE(within([&] { return rig.bench->disconnections == 1; }));
	EXPECT_EQ(rig.device.open(), DeviceStatus::Ok);
	EXPECT_EQ(rig.bench->connections, 2);
}

TEST(ThreadedDevice, AnAbsentDeviceIsExplainedAndComesLater)
{
	Rig rig;
	rig.bench->mood = Bench::Mood::Absent;
	EXPECT_EQ(rig.device.open(), DeviceStatus::Disconnected);
	EXPECT_EQ(rig.device.complaint(), "plug it in");
	EXPECT_EQ(rig.read(), DeviceStatus::Disconnected);
	rig.bench->mood = Bench::Mood::Good;
	EXPECT_EQ(rig.device.open(), DeviceStatus::Ok);
	EXPECT_EQ(rig.device.complaint(), "");
}

TEST(ThreadedDevice, ComesBackThroughTheReconnector)
{
	const auto bench = std::make_shared<Bench>();
	ReconnectingDevice device(std::make_unique<ThreadedDevice>(std::make_unique<BenchLink>(bench)), {1'000'000, 4'000'000});
	ASSERT_EQ(device.open(), DeviceStatus::Ok);
	DeviceState state;
	RealClock clock;
	for (std::uint64_t round = 1; round <= 3; ++round)
	{
		bench->mood = Bench::Mood::Pulled;
		EXPECT_TRUE(within([&] { return device.read(clock.now(), state) == DeviceStatus::Disconnected; }));
		bench->mood = Bench::Mood::Good;
		EXPECT_TRUE(within([&] { return device.read(clock.now(), state) == DeviceStatus::Ok; }));
		EXPECT_GE(device.reconnections(), round);
	}
	EXPECT_FALSE(bench->foreignCall);
}
