// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Loop/GapBridge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <thread>

#include "DeviceBridge/Coupling/VirtualCoupling.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"
#include "DeviceBridge/Loop/SteppingThread.h"

using namespace devicebridge;

namespace
{
constexpr double kTick = 1e-3;
constexpr std::int64_t kMs = 1'000'000;

/// A clock that oversleeps by `gap` after every `every` ticks.
class BusyClock final : public Clock
{
public:
	std::int64_t gap = 0;
	int every = 0;
	std::int64_t now() const noexcept override { return m_clock.now(); }
	void sleepUntil(std::int64_t deadline) noexcept override
	{
		const bool busy = every > 0 && ++m_sleeps % every == 0;
		m_clock.sleepUntil(deadline + (busy ? gap : 0));
	}

private:
	VirtualClock m_clock;
	int m_sleeps = 0;
};

/// A point of 0.1 kg on the coupling, above a rough floor z = 0 of 3 kN/m, integrated implicitly.
class RoughFloor final : public ContactSource
{
public:
	double longestStep = 0, farthest = 0;
	void advance(double dt, const DeviceState& hand, ToolStep& step) noexcept override
	{
		constexpr double kMass = 0.1, kStiffness = 3000, kFriction = 0.3;
		const CouplingGains gains{4000, 1, 0, 0, 12, 0.2};
		longestStep = std::max(longestStep, dt);
		ToolState& tool = m_tool;
		step.coupling = couplingOnTool(gains, hand.X_WH, hand.twist, tool, kMass, 1e-5, dt);
		step.coupling.torque = {};
		tool.twist.linear += step.coupling.force * (dt / kMass);
		const double depth = -tool.X_WT.translation.z;
		const double push = std::max(
			0.0, dt * (kStiffness * depth - (dt * kStiffness + 5) * tool.twist.linear.z) / (1 + dt * (dt * kStiffness + 5) / kMass));
		if (depth > 0)
		{
			tool.twist.linear.z += push / kMass;
			ist::Vec3 slip{tool.twist.linear.x, tool.twist.linear.y, 0};
			const double speed = norm(slip), most = kFriction * push / kMass;
			tool.twist.linear -= speed > most ? slip * (most / speed) : slip;
			step.contacts[step.contactCount++] = {{{0, 0, push / dt}, {}}, tool.X_WT.translation, {0, 0, 1}, depth * 1e-6, 1, this};
		}
		tool.X_WT.translation += dt * tool.twist.linear;
		step.tool = tool;
		farthest = std::max(farthest, distance(hand.X_WH.translation, tool.X_WT.translation));
	}
	void place(const ist::Vec3& at) { m_tool.X_WT.translation = at; }

private:
	ToolState m_tool;
};

struct Session
{
	double largestForce = 0, largestRise = 0, farthest = 0, longestStep = 0;
	std::uint64_t overruns = 0;
	ist::Vec3 end;
};

/// The hand presses with up to 4 N and slides to and fro at 0.15 m/s.
Session slide(std::int64_t gap, int every)
{
	SimulatedDevice device(simulatedProfile("sigma7").value());
	RoughFloor floor;
	floor.place({0, 0, 0.005});
	device.place({{}, {0, 0, 0.005}});
	std::vector<HandKeyFrame> frames{{0, {{}, {0, 0, 0.005}}}, {0.8, {{}, {0, 0, 0.005}}}, {1, {{}, {0, 0, -0.0133}}}};
	for (int i = 1; i <= 14; ++i) frames.push_back({1 + 0.4 * i, {{}, {i % 2 ? 0.06 : 0, 0, -0.0133}}});
	device.setHand(handThrough(frames));
	device.open();
	BusyClock clock;
	SteppingThread thread(device, floor, clock);
	Session session;
	double last = 0;
	while (clock.now() < 6000 * kMs)
	{
		if (clock.now() > 1500 * kMs) clock.gap = gap, clock.every = every;
		thread.run(1);
		const double force = norm(thread.sentWrench().force);
		session.largestForce = std::max(session.largestForce, force);
		session.largestRise = std::max(session.largestRise, force - last);
		last = force;
	}
	session.farthest = floor.farthest;
	session.longestStep = floor.longestStep;
	session.overruns = thread.overruns();
	session.end = device.truePose().translation;
	return session;
}
}  // namespace

TEST(GapBridge, WithoutGapsTheHandIsTakenAsItIs)
{
	std::mt19937_64 random(3);
	std::uniform_real_distribution<double> u(-1, 1);
	GapBridge bridge;
	for (int i = 0; i < 100; ++i)
	{
		const ist::Pose hand{rotationMatrix(ist::quaternionFromRotationVector(ist::Vec3{u(random), u(random), u(random)})),
			{u(random), u(random), 1000 * u(random)}};
		const ist::Pose seen = bridge.reference(hand, (1 + 2.9 * std::fabs(u(random))) * kTick, kTick);
		EXPECT_EQ(seen.translation, hand.translation);
		for (int j = 0; j < 3; ++j) EXPECT_EQ(seen.rotation.row(j), hand.rotation.row(j));
	}
}

// The displacement in the gap is subtracted and returns as exp(-t / 0.1 s).
TEST(GapBridge, TheWayOfAGapComesBackSlowly)
{
	const ist::Vec3 turn{0.1, -0.2, 0.05};
	GapBridge bridge;
	bridge.reference({{}, {1, 2, 3}}, kTick, kTick);
	const ist::Pose after{rotationMatrix(ist::quaternionFromRotationVector(turn)), {1.01, 2, 2.98}};
	ist::Pose seen = bridge.reference(after, 22 * kTick, kTick);
	EXPECT_LT(distance(seen.translation, {1, 2, 3}), 0.011 * 0.0224);
	for (int i = 1; i < 300; ++i) seen = bridge.reference(after, kTick, kTick);
	const double left = std::exp(-0.3 / GapBridge::kReturn);
	EXPECT_LT(norm(after.translation - seen.translation - left * ist::Vec3{0.01, 0, -0.02}), 1e-9);
	const ist::Vec3 turned = rotationVector(ist::quaternion(after.rotation * transpose(seen.rotation)));
	EXPECT_LT(norm(turned - left * turn), 1e-9);
}

// The machine is busy for 22 ms, longer than a command lives, and for 12 ms, shorter than that.
TEST(GapBridge, AGapInTheTicksWindsUpNoForce)
{
	const Session calm = slide(0, 0);
	EXPECT_EQ(calm.overruns, 0U);
	for (const std::int64_t gap : {12 * kMs, 22 * kMs})
		for (const int every : {7, 40, 200})
		{
			const Session busy = slide(gap, every);
			const Session again = slide(gap, every);
			EXPECT_GT(busy.overruns, 15U);
			EXPECT_LT(busy.largestForce, 1.25 * calm.largestForce) << gap << " every " << every;
			// Without a gap, the limiter lets the force rise by the device's peak in 20 ms.
			EXPECT_LT(busy.largestRise, 12.0 / 20) << gap << " every " << every;
			EXPECT_EQ(busy.longestStep, kTick);
			EXPECT_EQ(busy.end, again.end);
			std::printf("gap %lld ms every %d ticks: largest force %.2f N (calm %.2f), rise %.2f N, farthest %.2f mm\n",
				static_cast<long long>(gap / kMs), every, busy.largestForce, calm.largestForce, busy.largestRise, 1e3 * busy.farthest);
		}
}

namespace
{
/// A free tool that the coupling pulls to the hand.
class FreeTool final : public ContactSource
{
public:
	double farthest = 0;
	void advance(double dt, const DeviceState& hand, ToolStep& step) noexcept override
	{
		constexpr double kMass = 0.1;
		step.coupling = couplingOnTool({4000, 1, 0, 0, 12, 0.2}, hand.X_WH, hand.twist, m_tool, kMass, 1e-5, dt);
		step.coupling.torque = {};
		m_tool.twist.linear += step.coupling.force * (dt / kMass);
		m_tool.X_WT.translation += dt * m_tool.twist.linear;
		step.tool = m_tool;
		farthest = std::max(farthest, distance(hand.X_WH.translation, m_tool.X_WT.translation));
	}
	const ist::Vec3& place() const { return m_tool.X_WT.translation; }

private:
	ToolState m_tool;
};

/// A device at a given place that returns a given status.
class MovedDevice final : public Device
{
public:
	DeviceInfo description = simulatedProfile("sigma7").value().info;
	DeviceStatus answer = DeviceStatus::Ok;
	ist::Vec3 place;
	const DeviceInfo& info() const noexcept override { return description; }
	DeviceStatus open() noexcept override { return DeviceStatus::Ok; }
	void close() noexcept override {}
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override
	{
		if (answer != DeviceStatus::Ok) return answer;
		++state.sequence;
		state.sampledAt = now;
		state.X_WH.translation = place;
		return answer;
	}
	DeviceStatus write(const DeviceCommand&) noexcept override { return answer; }
};
}  // namespace

// The displacement is 5 cm, which the coupling would follow with its full force.
TEST(GapBridge, TheWayOfAnOutageAndOfAStopComesBackSlowly)
{
	for (const bool stopped : {false, true})
	{
		MovedDevice device;
		FreeTool tool;
		VirtualClock clock;
		SteppingSettings settings;
		settings.realTime = settings.lockMemory = false;
		SteppingThread thread(device, tool, clock, settings);
		thread.run(50);
		if (!stopped) device.answer = DeviceStatus::Disconnected;
		if (stopped) clock.sleepUntil(clock.now() + 100 * kMs);
		else thread.run(100);
		device.answer = DeviceStatus::Ok;
		device.place = {0.05, 0, 0};
		const std::uint64_t before = thread.ticks();
		ASSERT_EQ(stopped && thread.start(), stopped);
		while (stopped && thread.ticks() < before + 1000) std::this_thread::yield();
		thread.stop();
		if (!stopped) thread.run(1000);
		// The offset returns at up to 0.05 m / 0.1 s, which against 12 N s/m stretches 4 kN/m by 1.5 mm. In the first tick 0.5 mm return.
		EXPECT_LT(tool.farthest, 0.0025) << "stopped: " << stopped;
		EXPECT_LT(distance(tool.place(), device.place), 1e-4);
	}
}
