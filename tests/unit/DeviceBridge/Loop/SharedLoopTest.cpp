// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Loop/SteppingThread.h"

#include "tests/unit/CountingAllocator.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <stdexcept>
#include <string>
#include <thread>

#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"

using namespace devicebridge;

namespace
{
/// Appends its calls to the log of the test, and pulls at the hand with a constant force.
class LoggingSource final : public ContactSource
{
public:
	LoggingSource(std::string& log, char name, double force) : m_log(log), m_name(name), m_force(force) {}
	const char* refused = "";
	unsigned lastFlags = 0;
	void prepare(double, const DeviceState& hand) noexcept override
	{
		m_log += m_name;
		lastFlags = hand.flags;
	}
	void advance(double, const DeviceState& hand, ToolStep& step) noexcept override
	{
		m_log += static_cast<char>(m_name - 'a' + 'A');
		step.tool = {hand.X_WH, hand.twist};
		step.coupling = {{-m_force, 0, 0}, {}};
	}
	const char* refusal() const noexcept override { return refused; }

private:
	std::string& m_log;
	char m_name;
	double m_force;
};

/// A sigma.7 without a hand on it, which may stop to answer.
class Handle final : public Device
{
public:
	DeviceInfo description = simulatedProfile("sigma7").value().info;
	DeviceCommand last;
	bool silent = false;
	const DeviceInfo& info() const noexcept override { return description; }
	DeviceStatus open() noexcept override { return DeviceStatus::Ok; }
	void close() noexcept override {}
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override
	{
		if (silent) return DeviceStatus::Disconnected;
		state = {};
		state.sequence = ++m_reads;
		state.sampledAt = now;
		state.X_WH.translation.y = 1e-7 * std::sin(0.1 * double(m_reads));  // a hand trembles
		return DeviceStatus::Ok;
	}
	DeviceStatus write(const DeviceCommand& command) noexcept override
	{
		last = command;
		return DeviceStatus::Ok;
	}

private:
	std::uint64_t m_reads = 0;
};

/// Laws that push without end are an active world.
SteppingSettings settings(std::int64_t period = 1'000'000)
{
	SteppingSettings s;
	s.period = period;
	s.safety.passivity = false;
	return s;
}

struct TwoHands
{
	std::string log;
	Handle left, right;
	LoggingSource leftSource{log, 'a', 0.5}, rightSource{log, 'b', 1.5};
	VirtualClock clock;
	SteppingThread leftLoop{left, leftSource, clock, settings()}, rightLoop{right, rightSource, clock, settings()};

	TwoHands() { EXPECT_STREQ(leftLoop.addHand(rightLoop), ""); }
};
constexpr int kAfterRamp = 1200;  // [ticks]
}  // namespace

TEST(SharedLoop, AllHandsPullBeforeAnySourceAdvances)
{
	TwoHands hands;
	ASSERT_TRUE(hands.leftLoop.run(3));
	EXPECT_EQ(hands.log, "abABabABabAB");
	EXPECT_EQ(hands.leftLoop.ticks(), 3u);
	EXPECT_EQ(hands.rightLoop.ticks(), 3u);
}

TEST(SharedLoop, EachHandGetsItsOwnForce)
{
	TwoHands hands;
	ASSERT_TRUE(hands.leftLoop.run(kAfterRamp));
	EXPECT_DOUBLE_EQ(hands.left.last.wrench.force.x, 0.5);
	EXPECT_DOUBLE_EQ(hands.right.last.wrench.force.x, 1.5);
	hands.rightLoop.enableForces(false);
	ASSERT_TRUE(hands.leftLoop.run(1));
	EXPECT_DOUBLE_EQ(hands.left.last.wrench.force.x, 0.5);
	EXPECT_EQ(hands.right.last.wrench.force.x, 0);
}

TEST(SharedLoop, AHandHasTheOverrunsAndCostsOfItsLoop)
{
	TwoHands hands;
	hands.leftLoop.onTransform.addDelegate([&](const DeviceState&) {
		if (hands.leftLoop.ticks() == 5) hands.clock.sleepUntil(hands.clock.now() + 10'000'000);
	});
	ASSERT_TRUE(hands.leftLoop.run(20));
	EXPECT_EQ(hands.leftLoop.overruns(), 1u);
	EXPECT_EQ(hands.rightLoop.overruns(), 1u);
	EXPECT_EQ(hands.rightLoop.costs().count(), 20u);
	EXPECT_EQ(hands.rightLoop.periods().longest(), hands.leftLoop.periods().longest());
}

TEST(SharedLoop, ATickOfTwoHandsDoesNotAllocate)
{
	TwoHands hands;
	ASSERT_TRUE(hands.leftLoop.run(10));
	hands.log.reserve(100000);
	const long before = allocationCount();
	ASSERT_TRUE(hands.leftLoop.run(1000));
	EXPECT_EQ(allocationCount() - before, 0);
}

// The device of the first hand is silent, a listener of the second throws, and the other hand goes on each time.
TEST(SharedLoop, AFaultOfOneHandIsNotThatOfTheOther)
{
	TwoHands hands;
	ASSERT_TRUE(hands.leftLoop.run(kAfterRamp));
	hands.left.silent = true;
	ASSERT_TRUE(hands.leftLoop.run(50));
	EXPECT_EQ(hands.left.last.wrench.force.x, 0);
	EXPECT_EQ(hands.leftLoop.faultCause(), FaultCause::Disconnected);
	EXPECT_EQ(hands.leftSource.lastFlags & kHandPresent, 0u);
	EXPECT_DOUBLE_EQ(hands.right.last.wrench.force.x, 1.5);
	EXPECT_NE(hands.rightSource.lastFlags & kHandPresent, 0u);
	hands.left.silent = false;
	ASSERT_TRUE(hands.leftLoop.run(kAfterRamp));
	EXPECT_DOUBLE_EQ(hands.left.last.wrench.force.x, 0.5);
	for (const bool early : {true, false})
	{
		const auto bad = [](const auto&...) { throw std::runtime_error("no"); };
		const auto id = early ? hands.rightLoop.onTransform.addDelegate(bad) : hands.rightLoop.onHapticTick.addDelegate(bad);
		ASSERT_TRUE(hands.leftLoop.run(1));
		EXPECT_EQ(hands.right.last.wrench.force.x, 0);
		EXPECT_TRUE(hands.rightLoop.faulted());
		EXPECT_DOUBLE_EQ(hands.left.last.wrench.force.x, 0.5);
		EXPECT_FALSE(hands.leftLoop.faulted());
		(early ? hands.rightLoop.onTransform.removeDelegate(id) : hands.rightLoop.onHapticTick.removeDelegate(id));
		hands.rightLoop.clearFault();
	}
}

TEST(SharedLoop, AnyHandStopsItAndAllEndAtZero)
{
	for (const bool byOther : {true, false})
	{
		TwoHands hands;
		ASSERT_TRUE(hands.leftLoop.run(kAfterRamp));
		SteppingThread& stopper = byOther ? hands.rightLoop : hands.leftLoop;
		stopper.onTransform.addDelegate([&](const DeviceState&) { stopper.requestStop(); });
		ASSERT_TRUE(hands.leftLoop.run(100));
		EXPECT_EQ(hands.rightLoop.ticks(), kAfterRamp + 1u);
		EXPECT_EQ(hands.left.last.wrench.force.x, 0);
		EXPECT_EQ(hands.right.last.wrench.force.x, 0);
		EXPECT_FALSE(hands.rightLoop.running());
	}
	TwoHands hands;
	ASSERT_TRUE(hands.leftLoop.run(kAfterRamp));
	hands.rightLoop.stop();  // after a run that ended by itself
	EXPECT_EQ(hands.left.last.wrench.force.x, 0);
	EXPECT_EQ(hands.right.last.wrench.force.x, 0);
}

TEST(SharedLoop, RunsInRealTimeOnOneThread)
{
	std::string log;
	Handle left, right;
	LoggingSource leftSource{log, 'a', 0.5}, rightSource{log, 'b', 1.5};
	RealClock clock;
	SteppingThread leftLoop{left, leftSource, clock, settings()}, rightLoop{right, rightSource, clock, settings()};
	ASSERT_STREQ(leftLoop.addHand(rightLoop), "");
	ASSERT_TRUE(leftLoop.start());
	EXPECT_TRUE(rightLoop.running());
	while (rightLoop.ticks() < 20) std::this_thread::sleep_for(std::chrono::milliseconds(1));
	rightLoop.stop();
	EXPECT_FALSE(leftLoop.running());
	EXPECT_EQ(leftLoop.ticks(), rightLoop.ticks());
	EXPECT_EQ(log.substr(0, 8), "abABabAB");
	EXPECT_EQ(left.last.wrench.force.x, 0);
}

TEST(SharedLoop, SaysWhatItCannotShare)
{
	TwoHands hands;
	EXPECT_FALSE(hands.rightLoop.run(1));
	EXPECT_NE(std::string(hands.rightLoop.refusal()).find("start that one"), std::string::npos);
	EXPECT_FALSE(hands.rightLoop.start());
	EXPECT_STRNE(hands.leftLoop.addHand(hands.leftLoop), "");
	EXPECT_STRNE(hands.leftLoop.addHand(hands.rightLoop), "");
	EXPECT_STRNE(hands.rightLoop.addHand(hands.leftLoop), "");
	Handle device;
	LoggingSource source(hands.log, 'c', 1);
	SteppingThread slow(device, source, hands.clock, settings(2'000'000));
	EXPECT_NE(std::string(hands.leftLoop.addHand(slow)).find("different periods"), std::string::npos);
	{
		SteppingThread third(device, source, hands.clock, settings());
		EXPECT_STREQ(hands.leftLoop.addHand(third), "");
		hands.log.clear();
		ASSERT_TRUE(hands.leftLoop.run(1));
		EXPECT_EQ(hands.log, "abcABC");
	}
	hands.log.clear();
	ASSERT_TRUE(hands.leftLoop.run(1));  // without the hand that has gone
	EXPECT_EQ(hands.log, "abAB");
	hands.rightSource.refused = "no tree";
	EXPECT_FALSE(hands.leftLoop.run(1));
	EXPECT_STREQ(hands.leftLoop.refusal(), "no tree");
}
