// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Loop/ThreadedForceLaw.h"

#include "tests/unit/CountingAllocator.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"
#include "DeviceBridge/Loop/SteppingThread.h"

using namespace devicebridge;

namespace
{
/// A spring on the hand, on both sides of zero, so that contact is never lost.
class LinearWall final : public ContactSource
{
public:
	double stiffness = 800;
	void advance(double, const DeviceState& hand, ToolStep& step) noexcept override
	{
		step.tool = {hand.X_WH, hand.twist};
		step.coupling = {stiffness * hand.X_WH.translation, {}};
	}
};

/// The reaction of the coupling plus a force of its own.
class PushingLaw final : public ForceLaw
{
public:
	ist::Vec3 push;
	std::atomic<std::thread::id> caller{};
	ist::Wrench handWrench(const DeviceState&, const ToolStep& step) noexcept override
	{
		caller = std::this_thread::get_id();
		ist::Wrench wrench = -1.0 * step.coupling;
		wrench.force += push;
		return wrench;
	}
};

/// The unchanged wrench of the last answer, which would delay the coupling.
class HeldLaw final : public ForceLaw
{
public:
	ist::Wrench handWrench(const DeviceState&, const ToolStep& step) noexcept override
	{
		const ist::Wrench before = m_last;
		m_last = -1.0 * step.coupling;
		return before;
	}

private:
	ist::Wrench m_last;
};

SimulatedProfile bareProfile()
{
	SimulatedProfile p = simulatedProfile("sigma7").value();
	p.info.resolution = p.info.angularResolution = 0;
	p.handStiffness = p.handDamping = 0;
	return p;
}

SteppingSettings unguarded()
{
	SteppingSettings settings;
	settings.safety.passivity = false;
	settings.safety.rampTime = 0;
	return settings;
}

/// Largest amplitude of a free handle in the last part of a run, divided by its first amplitude.
template <class Between> double growth(double stiffness, ForceLaw& law, const Between& between)
{
	SimulatedDevice device(bareProfile());
	device.place({{}, {1e-4, 0, 0}});
	device.open();
	LinearWall wall;
	wall.stiffness = stiffness;
	VirtualClock clock;
	SteppingThread thread(device, wall, clock, unguarded());
	thread.setForceLaw(&law);
	double last = 0;
	for (int i = 0; i < 1500; ++i)
	{
		thread.run(1);
		between();
		if (i >= 1300) last = std::max(last, std::fabs(device.truePose().translation.x));
	}
	return last / 1e-4;
}
}  // namespace

// With b = 2 N s/m the loop is stable up to b/(T/2) = 4000 N/m without delay. There 3000 N/m decay as exp(-b (1 - 3/4) t / 2m), to a fifth
// in 1.3 s. With one tick of delay it is stable up to b/(3T/2) = 1333 N/m only.
TEST(ThreadedForceLaw, TheCouplingDoesNotLag)
{
	CouplingForceLaw coupling;
	ThreadedForceLaw threaded(coupling);
	HeldLaw held;
	EXPECT_LT(growth(3000, threaded, [&] { threaded.serve(); }), 0.3);
	EXPECT_GT(growth(3000, held, [] {}), 10);
	// From the first answer on, the wrench equals the one without a thread to the last bit.
	ThreadedForceLaw again(coupling);
	DeviceState hand;
	ToolStep step;
	for (int i = 0; i < 100; ++i)
	{
		step.coupling = {{std::sin(0.1 * i), 2.0 * i, -3}, {0.1 * i, 0.7, 1e-3}};
		hand.sampledAt = i;
		const ist::Wrench felt = again.handWrench(hand, step);
		EXPECT_EQ(felt.force, again.answers() > 0 ? -step.coupling.force : ist::Vec3());
		if (i % 3 == 0) again.serve();
	}
}

// As after a thread of the law that was stopped, or never started.
TEST(ThreadedForceLaw, InTheTickItWaitsForNoAnswerThatNoThreadHasBegunWith)
{
	PushingLaw law;
	law.push = {1, 0, 0};
	ThreadedForceLaw threaded(law);
	DeviceState hand;
	const ToolStep step;
	for (int round = 0; round < 3; ++round)
	{
		threaded.setThreaded(true);
		for (int i = 0; i < 10; ++i) (void)threaded.handWrench(hand, step);
		threaded.setThreaded(false);
		hand.sampledAt += 1000;
		law.push.x += 1;
		EXPECT_EQ(threaded.handWrench(hand, step).force.x, law.push.x);
		EXPECT_EQ(threaded.computedAt(hand), hand.sampledAt);
		EXPECT_FALSE(threaded.serve());
	}
	threaded.setThreaded(true);
	(void)threaded.handWrench(hand, step);
	EXPECT_TRUE(threaded.serve());
}

TEST(ThreadedForceLaw, WhatTheLawAddsIsThatOfItsLastAnswer)
{
	PushingLaw law;
	ThreadedForceLaw threaded(law);
	DeviceState hand;
	ToolStep step;
	std::int64_t asked = -1, answered = -1;
	for (int i = 0; i < 200; ++i)
	{
		hand.sampledAt = 1000 * i;
		law.push = {1.0 * i, 0, 0};
		step.coupling.force = {0, -5.0 * i, 0};
		const ist::Wrench felt = threaded.handWrench(hand, step);
		if (asked < 0) asked = i;
		if (answered >= 0)
		{
			EXPECT_EQ(felt.force.x, answered);
			EXPECT_EQ(felt.force.y, 5.0 * i);
			EXPECT_EQ(threaded.computedAt(hand), 1000 * answered);
		}
		// Every fourth tick brings an answer to the question of three ticks before.
		if (i % 4 != 3) continue;
		law.push = {static_cast<double>(asked), 0, 0};
		ASSERT_TRUE(threaded.serve());
		EXPECT_FALSE(threaded.serve());
		answered = asked;
		asked = -1;
	}
	EXPECT_EQ(threaded.answers(), 50U);
}

TEST(ThreadedForceLaw, ALawThatHangsLetsTheDeviceGo)
{
	SimulatedDevice device(simulatedProfile("sigma7").value());
	device.place({{}, {0.01, 0, 0}});
	device.open();
	LinearWall wall;
	VirtualClock clock;
	SteppingSettings settings = unguarded();
	SteppingThread thread(device, wall, clock, settings);
	CouplingForceLaw coupling;
	ThreadedForceLaw law(coupling);
	thread.setForceLaw(&law);
	for (int i = 0; i < 400; ++i) thread.run(1), law.serve();
	EXPECT_GT(norm(thread.sentWrench().force), 0.5);
	int ticks = 0;
	while (norm(thread.sentWrench().force) > 0 && ticks < 100) thread.run(1), ++ticks;
	EXPECT_GE(ticks, 5);
	EXPECT_LE(ticks, 21);
	for (int i = 0; i < 100; ++i) thread.run(1), law.serve();
	EXPECT_GT(norm(thread.sentWrench().force), 0.5);
	EXPECT_FALSE(thread.faulted());
}

TEST(ThreadedForceLaw, BackInItsThreadItGoesOnFromTheTickBefore)
{
	// The law runs in the tick for far longer than an answer may be old, with and without an earlier answer.
	const auto sent = [](bool answeredBefore, bool back) {
		SimulatedDevice device(simulatedProfile("sigma7").value());
		device.place({{}, {0.01, 0, 0}});
		device.open();
		LinearWall wall;
		VirtualClock clock;
		SteppingThread thread(device, wall, clock, unguarded());
		PushingLaw law;
		law.push = {0, 0.25, 0};
		ThreadedForceLaw threaded(law);
		thread.setForceLaw(&threaded);
		if (answeredBefore)
			for (int i = 0; i < 5; ++i) thread.run(1), threaded.serve();
		threaded.setThreaded(false);
		thread.run(100);
		threaded.setThreaded(back);
		thread.run(1);
		EXPECT_FALSE(thread.faulted());
		return thread.sentWrench().force;
	};
	for (const bool answeredBefore : {false, true})
	{
		const ist::Vec3 on = sent(answeredBefore, false), back = sent(answeredBefore, true);
		EXPECT_GT(norm(on), 0.5);
		EXPECT_LT(norm(back - on), 1e-9 * norm(on)) << answeredBefore;
	}
}

TEST(ThreadedForceLaw, ItsPlaceMayBeSwitchedWhileItRuns)
{
	SimulatedDevice device(simulatedProfile("sigma7").value());
	device.place({{}, {0.01, 0, 0}});
	device.open();
	LinearWall wall;
	RealClock clock;
	SteppingThread thread(device, wall, clock, unguarded());
	PushingLaw law;
	law.push = {0, 0.25, 0};
	ThreadedForceLaw threaded(law);
	thread.setForceLaw(&threaded);
	ASSERT_TRUE(threaded.start());
	EXPECT_FALSE(threaded.start());
	ASSERT_TRUE(thread.start());
	const auto wait = [&](const auto& done) {
		for (int i = 0; i < 5000 && !done(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
		return done();
	};
	EXPECT_TRUE(wait([&] { return threaded.answers() > 20; }));
	const std::thread::id own = law.caller;
	for (int turn = 0; turn < 3; ++turn)
	{
		threaded.setThreaded(false);
		EXPECT_TRUE(wait([&] { return law.caller.load() != own; }));
		const std::uint64_t answers = threaded.answers();
		std::this_thread::sleep_for(std::chrono::milliseconds(10));
		EXPECT_EQ(threaded.answers(), answers);
		threaded.setThreaded(true);
		EXPECT_TRUE(wait([&] { return threaded.answers() > answers && law.caller.load() == own; }));
	}
	thread.stop();
	threaded.stop();
	EXPECT_FALSE(thread.faulted());
	EXPECT_EQ(thread.sentWrench().force, ist::Vec3());
}

TEST(ThreadedForceLaw, ATickDoesNotAllocate)
{
	CouplingForceLaw coupling;
	ThreadedForceLaw law(coupling);
	DeviceState hand;
	ToolStep step;
	const auto before = allocationCount();
	for (int i = 0; i < 100; ++i)
	{
		law.handWrench(hand, step);
		law.computedAt(hand);
		if (i % 2) law.serve();
		if (i % 20 == 0) law.setThreaded(!law.threaded());
	}
	EXPECT_EQ(allocationCount(), before);
}
