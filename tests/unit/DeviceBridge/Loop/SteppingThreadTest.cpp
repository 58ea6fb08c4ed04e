// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Loop/SteppingThread.h"

#include "tests/unit/CountingAllocator.h"

#include <gtest/gtest.h>

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"

using namespace devicebridge;

namespace
{
/// A massless tool on the hand, and a wall that fills z < 0 with 800 N/m.
class AnalyticWall final : public ContactSource
{
public:
	int calls = 0;
	void advance(double, const DeviceState& hand, ToolStep& step) noexcept override
	{
		++calls;
		step.tool = {hand.X_WH, hand.twist};
		const double depth = std::max(0.0, -hand.X_WH.translation.z);
		step.coupling = {{0, 0, -800 * depth}, {}};
		if (depth == 0) return;
		step.contactCount = 1;
		step.contacts[0] = {{{0, 0, 800 * depth}, {}}, hand.X_WH.translation, {0, 0, 1}, depth * 1e-4, 1, this};
		step.overlapVolume = depth * 1e-4;
	}
};

class NoContact final : public ContactSource
{
public:
	void advance(double, const DeviceState& hand, ToolStep& step) noexcept override
	{
		step.tool = {hand.X_WH, hand.twist};
		step.coupling = {};
	}
};

class ConstantLaw final : public ForceLaw
{
public:
	ist::Wrench value{{1, 0, 0}, {}};
	std::int64_t at = -1;
	ist::Wrench handWrench(const DeviceState&, const ToolStep&) noexcept override { return value; }
	std::int64_t computedAt(const DeviceState& hand) const noexcept override { return at < 0 ? hand.sampledAt : at; }
};

struct Rig
{
	SimulatedDevice device{simulatedProfile("sigma7").value()};
	VirtualClock clock;

	Rig()
	{
		device.place({{}, {0, 0, 0.02}});
		device.setHand(handThrough({{0, {{}, {0, 0, 0.02}}}, {0.2, {{}, {0, 0, -0.02}}}}));
		device.open();
	}
};

/// Number of ticks after which the ramp is over.
constexpr int kAfterRamp = 600;

/// Settings for laws that push without end, which the passivity controller correctly treats as an active world.
SteppingSettings activeWorld()
{
	SteppingSettings settings;
	settings.safety.passivity = false;
	return settings;
}

class Broken final : public Device
{
public:
	DeviceInfo description = simulatedProfile("sigma7").value().info;
	DeviceCommand last;
	bool failing = false, nonsense = false;
	const DeviceInfo& info() const noexcept override { return description; }
	DeviceStatus open() noexcept override { return DeviceStatus::Ok; }
	void close() noexcept override {}
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override
	{
		state.sampledAt = now;
		if (nonsense) state.X_WH.translation.x = std::numeric_limits<double>::quiet_NaN();
		return failing ? DeviceStatus::Disconnected : DeviceStatus::Ok;
	}
	DeviceStatus write(const DeviceCommand& command) noexcept override
	{
		last = command;
		return DeviceStatus::Ok;
	}
};
}  // namespace

TEST(SteppingThread, RunsExactlyTheTicksAskedForInVirtualTime)
{
	Rig rig;
	AnalyticWall wall;
	SteppingThread thread(rig.device, wall, rig.clock);
	int transforms = 0, hapticTicks = 0, collisions = 0;
	thread.onTransform.addDelegate([&](const DeviceState&) { ++transforms; });
	thread.onCollision.addDelegate([&](const ToolContact& c) { collisions += c.other == &wall; });
	thread.onHapticTick.addDelegate([&](const DeviceState&, ist::Wrench&) { ++hapticTicks; });
	EXPECT_TRUE(thread.run(500));
	EXPECT_EQ(thread.ticks(), 500U);
	EXPECT_EQ(wall.calls, 500);
	EXPECT_EQ(transforms, 500);
	EXPECT_EQ(hapticTicks, 500);
	EXPECT_GT(collisions, 300);
	EXPECT_LT(collisions, 450);
	EXPECT_EQ(thread.overruns(), 0U);
	EXPECT_EQ(rig.clock.now(), 500'000'000);
	EXPECT_EQ(thread.periods().longest(), 1'000'000);
	EXPECT_NEAR(thread.periods().quantile(0.5), 1e6, 0.19e6);
}

TEST(SteppingThread, TheHandRestsOnTheWall)
{
	Rig rig;
	AnalyticWall wall;
	SteppingThread thread(rig.device, wall, rig.clock);
	thread.run(3000);
	// A hand of 300 N/m pulls from 20 mm below against a wall of 800 N/m.
	EXPECT_NEAR(rig.device.truePose().translation.z, -0.02 * 300 / 1100, 2e-5);
	EXPECT_NEAR(thread.sentWrench().force.z, 0.02 * 300 * 800 / 1100, 0.02);
}

TEST(SteppingThread, TwoRunsAreBitIdentical)
{
	std::vector<double> first, second;
	for (auto* trace : {&first, &second})
	{
		Rig rig;
		AnalyticWall wall;
		SteppingThread thread(rig.device, wall, rig.clock);
		for (int i = 0; i < 1000; ++i)
		{
			thread.run(1);
			trace->push_back(rig.device.truePose().translation.z);
			trace->push_back(thread.sentWrench().force.z);
		}
	}
	EXPECT_EQ(std::memcmp(first.data(), second.data(), first.size() * sizeof(double)), 0);
}

TEST(SteppingThread, SourceAndLawAreSwappedAloneAndTogether)
{
	for (const bool ownSource : {false, true})
		for (const bool ownLaw : {false, true})
		{
			Rig rig;
			NoContact empty;
			AnalyticWall wall;
			ConstantLaw law;
			SteppingThread thread(rig.device, ownSource ? static_cast<ContactSource&>(wall) : empty, rig.clock);
			if (ownLaw) thread.setForceLaw(&law);
			thread.run(3000);
			EXPECT_NEAR(thread.sentWrench().force.x, ownLaw ? 1 : 0, 1e-6);
			EXPECT_NEAR(thread.sentWrench().force.z, ownSource && !ownLaw ? 4.3636 : 0, 0.02);
			EXPECT_EQ(thread.step().contactCount, ownSource ? 1 : 0);
		}
}

TEST(SteppingThread, AListenerMayChangeTheWrench)
{
	Rig rig;
	NoContact empty;
	SteppingThread thread(rig.device, empty, rig.clock, activeWorld());
	thread.onHapticTick.addDelegate([](const DeviceState&, ist::Wrench& w) { w.force.y = 2; });
	thread.run(1);
	EXPECT_EQ(thread.wantedWrench().force.y, 2);
	EXPECT_LT(thread.sentWrench().force.y, 0.1) << "the ramp has only begun";
	thread.run(kAfterRamp);
	EXPECT_NEAR(rig.device.lastCommand().wrench.force.y, 2, 1e-12);
}

TEST(SteppingThread, NaNFromTheLawGivesZeroAtTheDevice)
{
	Rig rig;
	NoContact empty;
	ConstantLaw law;
	SteppingThread thread(rig.device, empty, rig.clock, activeWorld());
	thread.setForceLaw(&law);
	thread.run(kAfterRamp);
	EXPECT_EQ(rig.device.lastCommand().wrench.force.x, 1);
	law.value.force.y = std::numeric_limits<double>::quiet_NaN();
	thread.run(1);
	EXPECT_EQ(rig.device.lastCommand().wrench.force, ist::Vec3{});
	EXPECT_TRUE(thread.faulted());
	EXPECT_EQ(thread.safetyCounts().notFinite, 1U);
}

TEST(SteppingThread, AStaleLawFadesToZeroAtTheDevice)
{
	Rig rig;
	NoContact empty;
	ConstantLaw law;
	SteppingThread thread(rig.device, empty, rig.clock, activeWorld());
	thread.setForceLaw(&law);
	thread.run(kAfterRamp);
	law.at = rig.clock.now();
	thread.run(5);
	EXPECT_EQ(rig.device.lastCommand().wrench.force.x, 1);
	thread.run(5);
	EXPECT_NEAR(rig.device.lastCommand().wrench.force.x, 10 / 15.0, 1e-12);
	thread.run(10);
	EXPECT_EQ(rig.device.lastCommand().wrench.force.x, 0);
}

TEST(SteppingThread, AFailingOrNonsensicalDeviceGetsZero)
{
	for (const bool nonsense : {false, true})
	{
		Broken device;
		NoContact empty;
		ConstantLaw law;
		VirtualClock clock;
		SteppingThread thread(device, empty, clock);
		thread.setForceLaw(&law);
		thread.run(kAfterRamp);
		EXPECT_EQ(device.last.wrench.force.x, 1);
		device.failing = !nonsense;
		device.nonsense = nonsense;
		thread.run(1);
		EXPECT_EQ(device.last.wrench.force.x, 0);
		EXPECT_EQ(thread.deviceErrors(), 1U);
		EXPECT_EQ(thread.faulted(), nonsense);
		EXPECT_TRUE(isRigid(thread.step().tool.X_WT));
	}
}

TEST(SteppingThread, ATickDoesNotAllocate)
{
	Rig rig;
	AnalyticWall wall;
	SteppingThread thread(rig.device, wall, rig.clock);
	int heard = 0;
	thread.onTransform.addDelegate([&](const DeviceState&) { ++heard; });
	thread.onCollision.addDelegate([&](const ToolContact&) { ++heard; });
	thread.onHapticTick.addDelegate([&](const DeviceState&, ist::Wrench&) { ++heard; });
	const auto before = allocationCount();
	thread.run(2000);
	EXPECT_EQ(allocationCount(), before);
	EXPECT_GT(heard, 4000);
}

TEST(SteppingThread, AListenerMayStopIt)
{
	SimulatedDevice device(simulatedProfile("sigma7").value());
	device.open();
	AnalyticWall wall;
	RealClock clock;
	SteppingThread thread(device, wall, clock);
	std::atomic<int> ticks{0};
	thread.onHapticTick.addDelegate([&](const DeviceState&, ist::Wrench&) {
		if (++ticks == 3) thread.stop();
	});
	ASSERT_TRUE(thread.start());
	while (thread.running()) std::this_thread::yield();
	EXPECT_EQ(ticks, 3);
	EXPECT_EQ(thread.sentWrench().force, ist::Vec3());
	thread.stop();
}

TEST(SteppingThread, RunsOnItsOwnThreadAndEndsAtZero)
{
	Rig rig;
	ConstantLaw law;
	NoContact empty;
	RealClock clock;
	SteppingThread thread(rig.device, empty, clock);
	thread.setForceLaw(&law);
	ASSERT_TRUE(thread.start());
	EXPECT_FALSE(thread.start());
	EXPECT_FALSE(thread.run(1));
	EXPECT_NE(std::string(thread.refusal()).find("runs already"), std::string::npos) << thread.refusal();
	for (int i = 0; i < 2000 && thread.ticks() < 20; ++i) clock.sleepUntil(clock.now() + 5'000'000);
	thread.stop();
	EXPECT_FALSE(thread.running());
	EXPECT_GE(thread.ticks(), 20U);
	EXPECT_EQ(rig.device.lastCommand().wrench.force, ist::Vec3{});
	std::printf("memory %s; %s; period p50 %.0f us, longest %.0f us; tick p50 %.1f us; overruns %llu\n", thread.memory(),
		thread.scheduling(), thread.periods().quantile(0.5) / 1e3, static_cast<double>(thread.periods().longest()) / 1e3,
		thread.costs().quantile(0.5) / 1e3, static_cast<unsigned long long>(thread.overruns()));
	ASSERT_TRUE(thread.start());
	EXPECT_STREQ(thread.refusal(), "");
}

#if defined(__linux__)
namespace
{
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

/// Memory of this process that is never swapped out [kB].
long lockedMemory()
{
	std::ifstream status("/proc/self/status");
	for (std::string word; status >> word;)
		if (long kilobytes = 0; word == "VmLck:" && status >> kilobytes) return kilobytes;
	return -1;
}
}  // namespace

// A library does not decide this for its program, whatever the program's rights are.
TEST(SteppingThread, LocksTheMemoryOfTheProgramOnlyWhenAsked)
{
	for (const bool asked : {false, true})
	{
		Rig rig;
		NoContact empty;
		RealClock clock;
		SteppingSettings settings;
		EXPECT_FALSE(settings.lockMemory);
		if (asked) settings.lockMemory = true;
		const long before = lockedMemory();
		SteppingThread thread(rig.device, empty, clock, settings);
		ASSERT_TRUE(thread.start());
		for (int i = 0; i < 2000 && thread.ticks() < 3; ++i) clock.sleepUntil(clock.now() + 5'000'000);
		thread.stop();
		const std::string said = thread.memory();
		if (!asked)
		{
			EXPECT_EQ(said, "not locked: it was not asked for");
		}
		else
		{
			EXPECT_TRUE(said == "locked" || said.find("not locked: it was refused") == 0) << said;
		}
		// With the sanitizers mlockall() does nothing.
		if (said == "locked" && !kSanitized)
		{
			EXPECT_GT(lockedMemory(), before);
		}
		else
		{
			EXPECT_EQ(lockedMemory(), before);
		}
		munlockall();
	}
}
#endif

namespace
{
/// A device at rest that stores its last command; any thread may read it.
class MonitoredDevice final : public Device
{
public:
	DeviceInfo description = simulatedProfile("sigma7").value().info;
	std::atomic<double> force{0};
	std::atomic<int> inside{0}, most{0};  ///< number of threads that read or write at a time, and its maximum
	std::atomic<std::uint64_t> writes{0};
	const DeviceInfo& info() const noexcept override { return description; }
	DeviceStatus open() noexcept override { return DeviceStatus::Ok; }
	void close() noexcept override {}
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override
	{
		const int threads = ++inside;
		if (threads > most) most = threads;
		state.sampledAt = now;
		std::this_thread::yield();
		--inside;
		return DeviceStatus::Ok;
	}
	DeviceStatus write(const DeviceCommand& command) noexcept override
	{
		++writes;
		force = norm(command.wrench.force);
		return DeviceStatus::Ok;
	}
};

constexpr std::int64_t kForever = 1'000'000'000;

struct MonitoredRig
{
	MonitoredDevice device;
	NoContact empty;
	ConstantLaw law;
	RealClock clock;
	SteppingThread thread;
	MonitoredRig() : thread(device, empty, clock, quick()) { thread.setForceLaw(&law); }
	static SteppingSettings quick()
	{
		SteppingSettings settings = activeWorld();
		settings.realTime = false;
		settings.safety.rampTime = 5'000'000;
		settings.safety.fullUntil = 500'000'000;
		settings.safety.zeroFrom = 900'000'000;
		return settings;
	}
	template <class Condition> bool within(Condition condition)
	{
		for (int i = 0; i < 20000 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
		return condition();
	}
};
}  // namespace

TEST(SteppingThread, RunEndsWithTheTickInProgressWhenItIsStopped)
{
	for (const bool requested : {false, true})
	{
		MonitoredRig rig;
		std::atomic<bool> ran{false};
		std::thread runner([&] { ran = rig.thread.run(kForever); });
		ASSERT_TRUE(rig.within([&] { return rig.device.force > 0.5; }));
		EXPECT_TRUE(rig.thread.running());
		EXPECT_FALSE(ran);
		if (requested) rig.thread.requestStop();
		rig.thread.stop();
		const std::uint64_t at = rig.thread.ticks(), written = rig.device.writes;
		EXPECT_FALSE(rig.thread.running());
		EXPECT_EQ(rig.device.force, 0);
		std::this_thread::sleep_for(std::chrono::milliseconds(20));
		EXPECT_EQ(rig.thread.ticks(), at);
		EXPECT_EQ(rig.device.writes, written);
		runner.join();
		EXPECT_TRUE(ran);
		EXPECT_EQ(rig.thread.faults(), 0U);
		EXPECT_EQ(rig.thread.periods().count(), at);
	}
}

TEST(SteppingThread, WhileItRunsNoOtherLoopBegins)
{
	MonitoredRig rig;
	std::thread runner([&] { rig.thread.run(kForever); });
	ASSERT_TRUE(rig.within([&] { return rig.thread.ticks() > 0; }));
	EXPECT_FALSE(rig.thread.start());
	EXPECT_NE(std::string(rig.thread.refusal()).find("runs already"), std::string::npos) << rig.thread.refusal();
	EXPECT_FALSE(rig.thread.run(1));
	EXPECT_TRUE(rig.thread.running());
	rig.thread.stop();
	runner.join();
	EXPECT_TRUE(rig.thread.start());
	EXPECT_STREQ(rig.thread.refusal(), "");
	EXPECT_FALSE(rig.thread.run(1));
	rig.thread.stop();
	EXPECT_TRUE(rig.thread.run(3));
	EXPECT_EQ(rig.device.most, 1);
}

// Many threads run at once: one loop at a time is accepted, and the claim is released at the end.
TEST(SteppingThread, OfManyThatRunAtOnceOneDoes)
{
	MonitoredRig rig;
	std::atomic<long> accepted{0};
	std::vector<std::thread> threads;
	for (int i = 0; i < 4; ++i)
		threads.emplace_back([&] {
			for (int k = 0; k < 50; ++k) accepted += rig.thread.run(1);
		});
	for (std::thread& thread : threads) thread.join();
	EXPECT_GT(accepted, 0);
	EXPECT_EQ(rig.thread.ticks(), static_cast<std::uint64_t>(accepted));
	EXPECT_EQ(rig.device.most, 1);
	EXPECT_FALSE(rig.thread.running());
}

TEST(SteppingThread, AListenerStopsRunAndStartsNoOther)
{
	Rig rig;
	NoContact empty;
	ConstantLaw law;
	SteppingThread thread(rig.device, empty, rig.clock, activeWorld());
	thread.setForceLaw(&law);
	int ticks = 0, begun = 0;
	std::string refused;
	thread.onHapticTick.addDelegate([&](const DeviceState&, ist::Wrench&) {
		if (++ticks != kAfterRamp) return;
		begun += thread.run(1);
		begun += thread.start();
		refused = thread.refusal();
		thread.stop();
		EXPECT_TRUE(thread.running()) << "until the tick is over";
	});
	EXPECT_TRUE(thread.run(kForever));
	EXPECT_EQ(ticks, kAfterRamp);
	EXPECT_EQ(begun, 0);
	EXPECT_NE(refused.find("listener"), std::string::npos) << refused;
	EXPECT_FALSE(thread.running());
	EXPECT_EQ(rig.device.lastCommand().wrench.force, ist::Vec3());
	// The next run begins with a new schedule.
	EXPECT_TRUE(thread.run(5));
	EXPECT_EQ(ticks, kAfterRamp + 5);
	EXPECT_EQ(rig.device.lastCommand().wrench.force.x, 1);
	EXPECT_EQ(thread.overruns(), 0U);
}

TEST(SteppingThread, AStopThatComesBeforeALoopDoesNotStopIt)
{
	MonitoredRig rig;
	rig.thread.requestStop();
	EXPECT_TRUE(rig.thread.run(3));
	EXPECT_EQ(rig.thread.ticks(), 3U);
	rig.thread.stop();
	rig.thread.requestStop();
	ASSERT_TRUE(rig.thread.start());
	EXPECT_TRUE(rig.within([&] { return rig.thread.ticks() > 6; }));
	rig.thread.stop();
	rig.thread.stop();
	EXPECT_TRUE(rig.thread.run(0));
	EXPECT_TRUE(rig.thread.run(-5));
	EXPECT_FALSE(rig.thread.running());
}

// run() keeps the last command for the next run(); stop() sets it to zero.
TEST(SteppingThread, StopAfterRunLeavesTheDeviceAtZero)
{
	MonitoredRig rig;
	ASSERT_TRUE(rig.thread.run(50));
	EXPECT_EQ(rig.device.force, 1);
	rig.thread.stop();
	EXPECT_EQ(rig.device.force, 0);
	const std::uint64_t written = rig.device.writes;
	rig.thread.stop();
	EXPECT_EQ(rig.device.writes, written) << "it is at zero already";
}

TEST(SteppingThread, WhatAListenerThrowsLeavesRunStoppable)
{
	MonitoredRig rig;
	rig.thread.onHapticTick.addDelegate([](const DeviceState&, ist::Wrench&) { throw std::runtime_error("a hook"); });
	std::thread runner([&] { rig.thread.run(kForever); });
	ASSERT_TRUE(rig.within([&] { return rig.thread.ticks() > 3; }));
	EXPECT_TRUE(rig.thread.faulted());
	rig.thread.stop();
	runner.join();
	EXPECT_FALSE(rig.thread.running());
	EXPECT_EQ(rig.device.force, 0);
}

// In every order, from two threads, the loops never overlap, and the device is at zero after each stop.
TEST(SteppingThread, RunStopAndStartInAnyOrder)
{
	MonitoredRig rig;
	std::atomic<bool> ending{false};
	std::atomic<long> runs{0}, refused{0};
	std::thread runner([&] {
		while (!ending) (rig.thread.run(7) ? runs : refused) += 1;
	});
	std::mt19937 random(3);
	long started = 0;
	for (int i = 0; i < 150; ++i)
	{
		switch (random() % 4)
		{
		case 0: started += rig.thread.start(); break;
		case 1: rig.thread.requestStop(); break;
		case 2: rig.thread.stop(); break;
		default: std::this_thread::sleep_for(std::chrono::microseconds(random() % 3000));
		}
	}
	ending = true;
	rig.thread.stop();
	runner.join();
	rig.thread.stop();
	EXPECT_EQ(rig.device.force, 0);
	EXPECT_EQ(rig.device.most, 1);
	EXPECT_FALSE(rig.thread.running());
	EXPECT_GT(runs + started, 0);
}
