// SPDX-License-Identifier: Zlib
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "DeviceBridge/Decorators/MountedDevice.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "DeviceBridge/Loop/StopSignals.h"
#if defined(_WIN32)
#include "tests/unit/OwnConsole.h"
#endif

using namespace devicebridge;

namespace
{
constexpr std::int64_t kMs = 1'000'000;
constexpr int kSettled = 1500;  // number of ticks until the ramp is over and the hand rests on the wall

/// A simulated hand whose cable, encoders and firmware can be made to fail.
class FaultyDevice final : public Device
{
public:
	SimulatedDevice hand{simulatedProfile("sigma7").value()};
	bool unplugged = false, frozen = false, refuses = false;
	ist::Vec3 jump;
	bool holds = false;  ///< whether the position stays that of the first sample to the last bit
	double turn = 0;     ///< angle of the handle about z while it holds [rad]
	DeviceInfo description = hand.info();
	DeviceCommand last;

	const DeviceInfo& info() const noexcept override { return description; }
	DeviceStatus open() noexcept override { return hand.open(); }
	void close() noexcept override { hand.close(); }
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override
	{
		DeviceState fresh;
		hand.read(now, fresh);
		if (unplugged) return DeviceStatus::Disconnected;
		if (!frozen) m_sample = fresh;
		state = m_sample;
		state.X_WH.translation += jump;
		if (!holds) m_held = state.X_WH;
		else
		{
			state.X_WH = {rotationMatrix(ist::quaternionFromRotationVector({0, 0, turn})) * m_held.rotation, m_held.translation};
			state.twist = {};
		}
		return DeviceStatus::Ok;
	}
	DeviceStatus write(const DeviceCommand& command) noexcept override
	{
		if (unplugged || refuses) return DeviceStatus::Disconnected;
		last = command;
		return hand.write(command);
	}

private:
	DeviceState m_sample;
	ist::Pose m_held;
};

/// A wall of 800 N/m below z = 0 that may delay a tick.
class SlowWall final : public ContactSource
{
public:
	Clock* clock = nullptr;
	std::int64_t stall = 0;
	void advance(double, const DeviceState& hand, ToolStep& step) noexcept override
	{
		if (clock && stall > 0) clock->sleepUntil(clock->now() + stall);
		stall = 0;
		step.tool = {hand.X_WH, hand.twist};
		const double depth = std::max(0.0, -hand.X_WH.translation.z);
		step.coupling = {{0, 0, -800 * depth}, {}};
		if (depth > 0) step.contacts[step.contactCount++] = {{}, hand.X_WH.translation, {0, 0, 1}, depth, 1, this};
	}
};

class JumpingClock final : public Clock
{
public:
	std::int64_t offset = 0;
	std::int64_t now() const noexcept override { return m_clock.now() + offset; }
	void sleepUntil(std::int64_t deadline) noexcept override { m_clock.sleepUntil(deadline - offset); }
	std::int64_t slept() const { return m_clock.now(); }

private:
	VirtualClock m_clock;
};

struct FaultRig
{
	FaultyDevice device;
	SlowWall wall;
	JumpingClock clock;
	SteppingThread thread{device, wall, clock};
	std::vector<Fault> faults;

	FaultRig()
	{
		device.hand.place({{}, {0, 0, 0.02}});
		device.hand.setHand(handThrough({{0, {{}, {0, 0, 0.02}}}, {0.2, {{}, {0, 0, -0.02}}}}));
		device.open();
		wall.clock = &clock;
		thread.onFault.addDelegate([this](const Fault& fault) { faults.push_back(fault); });
		thread.run(kSettled);
	}
	/// Force that the device exerts at the moment [N].
	double force() const { return clock.now() < device.last.expiresAt ? norm(device.last.wrench.force) : 0; }
	/// Number of ticks until the force is zero, at most `most`.
	int ticksToZero(int most = 100)
	{
		int n = 0;
		while (n < most && force() > 0) thread.run(1), ++n;
		return n;
	}
};
}  // namespace

TEST(SteppingFault, WithoutAFaultTheHandFeelsTheWall)
{
	FaultRig rig;
	EXPECT_GT(rig.force(), 4);
	EXPECT_TRUE(rig.faults.empty());
	EXPECT_EQ(rig.thread.faultCause(), FaultCause::None);
}

TEST(SteppingFault, AnUnpluggedDeviceComesBackAtZeroAndNotInsideTheWall)
{
	FaultRig rig;
	rig.device.unplugged = true;
	EXPECT_LE(rig.ticksToZero(), 20);
	rig.thread.run(100);
	ASSERT_EQ(rig.faults.size(), 1U);
	EXPECT_EQ(rig.faults[0].cause, FaultCause::Disconnected);
	EXPECT_FALSE(rig.faults[0].latched);
	rig.device.unplugged = false;
	rig.thread.run(1000);
	EXPECT_EQ(rig.force(), 0);  // the hand is 20 mm inside
	EXPECT_GT(rig.thread.safetyCounts().startInside, 900U);
	rig.device.hand.setHand([](double) { return HandTarget{{{}, {0, 0, 0.01}}, {}}; });
	rig.thread.run(300);
	rig.device.hand.setHand([](double) { return HandTarget{{{}, {0, 0, -0.02}}, {}}; });
	rig.thread.run(kSettled);
	EXPECT_GT(rig.force(), 4);
	EXPECT_EQ(rig.thread.faultCause(), FaultCause::None);
}

TEST(SteppingFault, FrozenSamplesEndInZero)
{
	FaultRig rig;
	rig.device.frozen = true;
	EXPECT_LE(rig.ticksToZero(), 20);
	ASSERT_FALSE(rig.faults.empty());
	EXPECT_EQ(rig.faults[0].cause, FaultCause::Frozen);
}

TEST(SteppingFault, AJumpOfTenCentimetresIsNotFelt)
{
	FaultRig rig;
	// Without the check the wall would push with 80 N, which saturation limits to 12 N.
	rig.device.jump = {0, 0, -0.1};
	EXPECT_LE(rig.ticksToZero(), 1);
	ASSERT_FALSE(rig.faults.empty());
	EXPECT_EQ(rig.faults[0].cause, FaultCause::Jump);
	double largest = 0;
	for (int i = 0; i < 500; ++i)
	{
		rig.thread.run(1);
		largest = std::max(largest, rig.force());
	}
	EXPECT_EQ(largest, 0);
}

TEST(SteppingFault, AWorldThatStallsLetsTheDeviceGoAfterTwentyMilliseconds)
{
	FaultRig rig;
	const std::int64_t stalledAt = rig.clock.now();
	rig.wall.stall = 100 * kMs;
	// The command before the stall is the last that the device has, and it expires at its own time.
	EXPECT_LE(rig.device.last.expiresAt, stalledAt + 20 * kMs);
	rig.thread.run(1);
	EXPECT_GE(rig.clock.now(), stalledAt + 100 * kMs);
	EXPECT_EQ(norm(rig.device.last.wrench.force), 0);
	ASSERT_EQ(rig.faults.size(), 1U);
	EXPECT_EQ(rig.faults[0].cause, FaultCause::Stalled);
	rig.thread.run(2);
	EXPECT_LT(rig.force(), 0.1);
	rig.thread.run(kSettled);
	EXPECT_GT(rig.force(), 4);
}

TEST(SteppingFault, AClockThatJumpsBackDoesNotHoldTheLoop)
{
	FaultRig rig;
	for (const std::int64_t jump : {-10'000 * kMs, -1 * kMs, 5'000 * kMs, -60'000 * kMs})
	{
		rig.clock.offset += jump;
		const std::int64_t slept = rig.clock.slept();
		rig.thread.run(1);
		EXPECT_LT(norm(rig.device.last.wrench.force), 0.1);
		rig.thread.run(9);
		EXPECT_LE(rig.clock.slept() - slept, 11 * kMs);
		rig.thread.run(kSettled);
	}
	EXPECT_EQ(rig.thread.clockJumps(), 3U);
}

TEST(SteppingFault, AnExceptionInAHookIsAFaultAndZeroUntilCleared)
{
	const std::vector<std::function<void(SteppingThread&, bool&)>> hooks = {[](SteppingThread& t, bool& bad) {
																				t.onTransform.addDelegate([&](const DeviceState&) {
																					if (bad) throw std::runtime_error("transform");
																				});
																			},
		[](SteppingThread& t, bool& bad) {
			t.onCollision.addDelegate([&](const ToolContact&) {
				if (bad) throw 42;
			});
		},
		[](SteppingThread& t, bool& bad) {
			t.onHapticTick.addDelegate([&](const DeviceState&, ist::Wrench&) {
				if (bad) throw std::bad_alloc();
			});
		}};
	for (const auto& hook : hooks)
	{
		FaultRig rig;
		bool bad = false;
		hook(rig.thread, bad);
		rig.thread.run(10);
		EXPECT_GT(rig.force(), 4);
		bad = true;
		rig.thread.run(1);
		EXPECT_EQ(rig.force(), 0);
		ASSERT_EQ(rig.faults.size(), 1U);
		EXPECT_EQ(rig.faults[0].cause, FaultCause::HookException);
		EXPECT_TRUE(rig.faults[0].latched);
		bad = false;
		rig.thread.run(100);
		EXPECT_EQ(rig.force(), 0);
		EXPECT_EQ(rig.thread.faultCause(), FaultCause::HookException);
		rig.thread.clearFault();
		rig.thread.run(1);
		EXPECT_EQ(rig.thread.faultCause(), FaultCause::None);
	}
}

// No tick lies between the last exception and clearFault().
TEST(SteppingFault, AForceThatAnExceptionTookAwayComesBackAsAfterEnabling)
{
	FaultRig rig;
	bool bad = true;
	rig.thread.onHapticTick.addDelegate([&](const DeviceState&, ist::Wrench&) {
		if (bad) throw 1;
	});
	rig.thread.run(100);
	bad = false;
	rig.thread.clearFault();
	rig.thread.run(200);
	EXPECT_EQ(rig.thread.faultCause(), FaultCause::None);
	EXPECT_EQ(rig.force(), 0);  // the hand is 20 mm inside
	EXPECT_GT(rig.thread.safetyCounts().startInside, 150U);
}

TEST(SteppingFault, ADeviceThatRefusesCommandsTakesThemAgainFromZeroAndNotInsideTheWall)
{
	for (const int refused : {3, 100})
	{
		FaultRig rig;
		rig.device.refuses = true;
		rig.thread.run(refused);
		EXPECT_EQ(rig.thread.faultCause(), FaultCause::Disconnected);
		rig.device.refuses = false;
		rig.thread.run(200);
		// A glitch is bridged by the slew limit.
		EXPECT_NEAR(rig.force(), refused == 3 ? 6 : 0, refused == 3 ? 2 : 0);
	}
}

TEST(SteppingFault, AnExceptionInTheFaultListenerItselfEndsAtTheTick)
{
	FaultRig rig;
	rig.thread.onFault.addDelegate([](const Fault&) { throw 1; });
	rig.device.unplugged = true;
	rig.thread.run(25);
	EXPECT_TRUE(rig.thread.faulted());
	EXPECT_EQ(rig.force(), 0);
}

TEST(SteppingFault, SwitchedOffForcesAreZeroInTheNextTick)
{
	FaultRig rig;
	rig.thread.enableForces(false);
	EXPECT_LE(rig.ticksToZero(), 1);
	EXPECT_GT(rig.thread.safetyCounts().disabled, 0U);
	rig.thread.enableForces(true);
	rig.thread.run(100);
	EXPECT_EQ(rig.force(), 0);  // the tool is still inside
}

namespace
{
/// A thread that exerts a force ends with its device at zero once `stop` has been called.
void expectStopLeavesZero(int number, const std::function<void()>& stop)
{
	FaultyDevice device;
	device.hand.place({{}, {0, 0, 0.02}});
	device.open();
	SlowWall wall;
	RealClock clock;
	SteppingThread thread(device, wall, clock);
	thread.onHapticTick.addDelegate([](const DeviceState&, ist::Wrench& w) { w.force.x = 1; });
	std::atomic<bool> pushed{false};
	thread.onHapticTick.addDelegate(
		[&](const DeviceState&, const ist::Wrench&) { pushed = pushed || norm(thread.sentWrench().force) > 0; });
	StopSignals signals(thread);
	ASSERT_TRUE(signals.active());
	ASSERT_TRUE(thread.start());
	for (int i = 0; i < 4000 && !pushed; ++i) clock.sleepUntil(clock.now() + kMs);
	EXPECT_TRUE(pushed);
	stop();
	// The loop is bounded, so that a thread that continues fails the test instead of blocking it.
	for (int i = 0; i < 4000 && thread.running(); ++i) clock.sleepUntil(clock.now() + kMs);
	EXPECT_FALSE(thread.running());
	EXPECT_EQ(StopSignals::caught(), number);
	thread.stop();
	EXPECT_EQ(device.last.wrench.force, ist::Vec3{});
}
}  // namespace

#if defined(_WIN32)
TEST(SteppingFault, CtrlCEndsTheThreadWithTheDeviceAtZero)
{
	if (!hasOwnConsole())
	{
		EXPECT_EQ(runTestInOwnConsole(), 0U);
		return;
	}
	ignoreCtrlC(false);
	expectStopLeavesZero(SIGINT, [] { EXPECT_TRUE(pressCtrlC()); });
}
#else
TEST(SteppingFault, SignalsEndTheThreadWithTheDeviceAtZero)
{
	for (const int number : {SIGINT, SIGTERM}) expectStopLeavesZero(number, [number] { std::raise(number); });
}
#endif

TEST(SteppingFault, TheDestructorLeavesTheDeviceAtZero)
{
	FaultyDevice device;
	device.open();
	SlowWall wall;
	VirtualClock clock;
	{
		SteppingThread thread(device, wall, clock);
		thread.onHapticTick.addDelegate([](const DeviceState&, ist::Wrench& w) { w.force.x = 1; });
		thread.run(600);
		EXPECT_GT(norm(device.last.wrench.force), 0.1);
	}
	EXPECT_EQ(device.last.wrench.force, ist::Vec3{});
}

namespace
{
/// A hand that presses 5 mm into the wall from 1 s on, and turns its wrist by 1 rad/s, on a simulated device with a fault.
struct SpoiledRig
{
	SimulatedDevice device;
	SlowWall wall;
	VirtualClock clock;
	SteppingThread thread{device, wall, clock};
	double largest = 0, steepest = 0;  ///< force, and its largest rise in a tick [N]

	static SimulatedProfile profile(SimulatedFault fault, double at)
	{
		SimulatedProfile p = simulatedProfile("sigma7").value();
		p.fault = fault;
		p.faultAt = at;
		return p;
	}
	SpoiledRig(SimulatedFault fault, double at) : device(profile(fault, at))
	{
		device.setHand([](double t) {
			ist::Pose pose;
			pose.translation.z = t < 1 ? 0.01 : -0.005;
			pose.rotation = rotationMatrix(ist::quaternionFromRotationVector({0, 0, t}));
			return HandTarget{pose, {{}, {0, 0, 1}}};
		});
		ist::Pose start;
		start.translation.z = 0.01;
		device.place(start);
		device.open();
		thread.enableForces(true);
		clock.sleepUntil(1'000'000'000);  // the clock has run for a second before the first tick
	}
	double force() const { return norm(device.lastCommand().wrench.force); }
	void run(int ticks)
	{
		for (int i = 0; i < ticks; ++i)
		{
			const double before = force();
			thread.run(1);
			steepest = std::max(steepest, force() - before);
			largest = std::max(largest, force());
		}
	}
};
}  // namespace

TEST(SteppingFault, AnAxisThatIsNotANumberEndsTheForceUntilItIsCleared)
{
	SpoiledRig r(SimulatedFault::NanInOneAxis, 2);
	r.run(1900);
	ASSERT_GT(r.force(), 0.5);
	r.run(200);
	EXPECT_EQ(r.force(), 0);
	EXPECT_EQ(r.thread.faultCause(), FaultCause::InvalidState);
	EXPECT_TRUE(isFinite(r.thread.wantedWrench()) && isRigid(r.thread.state().X_WH));
}

// The position alone would keep the force for ever, although the hand has moved away.
TEST(SteppingFault, APositionThatStandsStillWhileTheWristTurnsEndsTheForce)
{
	SpoiledRig r(SimulatedFault::FrozenPosition, 2);
	r.run(1900);
	ASSERT_GT(r.force(), 0.5);
	r.run(650);
	EXPECT_EQ(r.force(), 0);
	EXPECT_EQ(r.thread.faultCause(), FaultCause::PositionFrozen);
	EXPECT_NE(std::string(describe(r.thread.faultCause())).find("calibrate the device"), std::string::npos);
}

// The position of a hand at rest may stay the same for seconds, while the hand trembles about its axes. A larger turn is a fault, which
// shows that the check is on.
TEST(SteppingFault, AHandAtRestIsNoFrozenPosition)
{
	FaultyDevice device;
	device.description.turnsInPlace = false;
	device.open();
	SlowWall wall;
	VirtualClock clock;
	SteppingThread thread(device, wall, clock);
	thread.run(100);
	device.holds = true;
	for (int i = 0; i < 6000; ++i)
	{
		device.turn = 0.2 * std::sin(0.05 * i);
		thread.run(1);
		ASSERT_EQ(thread.faultCause(), FaultCause::None) << i;
	}
	for (; device.turn < 1; device.turn += 0.001) thread.run(1);
	EXPECT_EQ(thread.faultCause(), FaultCause::PositionFrozen);
}

// The limits are those of the handle: 1 m/s is no jump, and 0.2 m in a millisecond is one.
TEST(SteppingFault, AScaledDeviceIsJudgedByItsHandle)
{
	for (const double scale : {0.01, 1.0, 100.0})
	{
		auto owned = std::make_unique<FaultyDevice>();
		FaultyDevice* inner = owned.get();
		MountedDevice device(std::move(owned), {}, scale);
		inner->hand.place({{}, {0, 0, 0.02}});
		inner->hand.setHand(handThrough({{0, {{}, {0, 0, 0.02}}}, {0.1, {{}, {0, 0, 0.12}}}}));
		device.open();
		SlowWall wall;
		VirtualClock clock;
		SteppingThread thread(device, wall, clock);
		for (int i = 0; i < 400; ++i)
		{
			thread.run(1);
			ASSERT_EQ(thread.faultCause(), FaultCause::None) << scale << ", tick " << i;
		}
		inner->jump = {0.2, 0, 0};
		thread.run(1);
		EXPECT_EQ(thread.faultCause(), FaultCause::Jump) << scale;
	}
}

TEST(SteppingFault, ASampleThatWasNeverTakenGivesNoForce)
{
	SpoiledRig r(SimulatedFault::ValidBeforeRead, 0.8);
	r.run(790);
	EXPECT_EQ(r.largest, 0);
	EXPECT_EQ(r.thread.faultCause(), FaultCause::Frozen);
	r.run(1500);
	EXPECT_EQ(r.thread.faultCause(), FaultCause::None);
	EXPECT_GT(r.force(), 0.5);
	EXPECT_LE(r.steepest, r.device.info().peakForce / 20 * (1 + 1e-9));  // the peak in 20 ms
}
