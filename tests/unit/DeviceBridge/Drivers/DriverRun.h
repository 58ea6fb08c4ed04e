// SPDX-License-Identifier: Zlib
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "DeviceBridge/Coupling/DeviceGains.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "tests/unit/TestEnvironment.h"

namespace devicebridge
{
/// OpenXR's loader would print to stderr whenever the drivers are listed.
inline const bool kQuietOpenXr = setenv("XR_LOADER_DEBUG", "none", 0) == 0;

/// Waits, far longer than necessary, for an effect of another thread or process.
template <class Condition> bool within(Condition condition, int milliseconds = 20000)
{
	for (int i = 0; i < milliseconds; ++i)
	{
		if (condition()) return true;
		std::this_thread::sleep_for(std::chrono::milliseconds(1));
	}
	return condition();
}

class NoContact final : public ContactSource
{
public:
	void advance(double, const DeviceState& hand, ToolStep& step) noexcept override { step.tool = {hand.X_WH, hand.twist}; }
};

class SteadyPush final : public ForceLaw
{
public:
	ist::Wrench wrench{{0, 0, 0.5}, {0, 0.01, 0}};
	ist::Wrench handWrench(const DeviceState&, const ToolStep&) noexcept override { return wrench; }
};

/// The whole haptic loop in real time around one device, one tick at a time on the test's own thread.
class DriverRun
{
public:
	SteadyPush law;

	explicit DriverRun(Device& device) : m_thread(device, m_world, m_clock, settings())
	{
		m_thread.setForceLaw(&law);
		m_thread.onFault.addDelegate([this](const Fault& fault) { m_lastFault = fault.cause; });
	}
	const SteppingThread& thread() const { return m_thread; }
	SteppingThread& thread() { return m_thread; }
	double force() const { return norm(m_thread.sentWrench().force); }
	double torque() const { return norm(m_thread.sentWrench().torque); }

	template <class Condition> bool until(Condition condition, int ticks = 10000)
	{
		for (int i = 0; i < ticks && !condition(); ++i) m_thread.run(1);
		return condition();
	}

	/// The force that is sent when the hand is 5 mm from a tool that is held. The coupling is that of the recipe of docs/stability.md, with
	/// `damping` of the mechanism; without it, of gainsForDevice().
	double forceByRecipe(const Device& device, double damping)
	{
		const CouplingGains gains = damping > 0 ? passiveGains(device.info(), damping, 0, 0.001) : gainsForDevice(device.info(), 0.001);
		EXPECT_GT(gains.stiffness, 0) << device.info().source;
		EXPECT_GT(gains.maxForce, 0) << device.info().source;
		ist::Pose X_WH;
		X_WH.translation = {0, 0, 0.005};
		law.wrench = -1.0 * staticPull(gains, X_WH, {});
		until([&] { return force() > 0; });
		return force();
	}

	/// `pull` unplugs the cable while force flows: the force ends, the cause is reported, and no call hangs.
	template <class Pull> void expectLossIsSafe(Device& device, Pull pull, bool exertsForce = true)
	{
		if (exertsForce)
		{
			ASSERT_TRUE(until([&] { return force() > 0; }));
		}
		else m_thread.run(5);
		pull();
		EXPECT_TRUE(until([&] { return m_thread.faultCause() == FaultCause::Disconnected; }));
		EXPECT_EQ(force(), 0);
		EXPECT_EQ(torque(), 0);
		EXPECT_EQ(m_lastFault, FaultCause::Disconnected);
		EXPECT_FALSE(device.complaint().empty());
		device.close();
		DeviceState state;
		EXPECT_EQ(device.read(m_clock.now(), state), DeviceStatus::NotOpen);
	}

private:
	static SteppingSettings settings()
	{
		SteppingSettings s;
		s.realTime = false;
		s.safety.rampTime = 5'000'000;
		s.safety.fullUntil = 500'000'000;  // these tests share two cores with others
		s.safety.zeroFrom = 900'000'000;
		return s;
	}

	NoContact m_world;
	RealClock m_clock;
	SteppingThread m_thread;
	FaultCause m_lastFault = FaultCause::None;
};
}  // namespace devicebridge
