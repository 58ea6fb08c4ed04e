// SPDX-License-Identifier: Zlib
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "DeviceBridge/Decorators/ClutchedDevice.h"
#include "DeviceBridge/Decorators/DelayedDevice.h"
#include "DeviceBridge/Decorators/MountedDevice.h"
#include "DeviceBridge/Decorators/RecordingDevice.h"
#include "DeviceBridge/Decorators/RestrictedDevice.h"
#include "DeviceBridge/Decorators/VelocityFilter.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "DeviceBridge/Loop/ThreadedForceLaw.h"

using namespace devicebridge;

namespace
{
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();

/// Checks between the tests and the mechanism: everything that must hold for each command after any operations.
struct Invariants
{
	std::atomic<std::uint64_t> writes{0}, notFinite{0}, tooLarge{0}, grips{0};
	std::atomic<double> lastForce{0};
};

class SpiedDevice final : public Device
{
public:
	enum Trouble
	{
		None,
		Unplugged,
		Frozen,
		Jumped,
		NotFinite,
		NotRigid,
		TwistNotFinite,
		WritesRefused,
		NotReady,
		Troubles
	};
	SpiedDevice(const SimulatedProfile& profile, Invariants& invariants, std::atomic<int>& trouble)
		: m_hand(profile),
		  m_invariants(invariants),
		  m_trouble(trouble)
	{
		m_hand.place({{}, {0, 0, 0.002}});
		m_hand.setHand([](double t) { return HandTarget{{{}, {0.004 * std::sin(9 * t), 0, 0.01 * std::cos(5 * t)}}, {}}; });
	}
	const DeviceInfo& info() const noexcept override { return m_hand.info(); }
	DeviceStatus open() noexcept override { return m_hand.open(); }
	void close() noexcept override { m_hand.close(); }
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override
	{
		const int trouble = m_trouble;
		DeviceState fresh;
		const DeviceStatus status = m_hand.read(now, fresh);
		if (trouble == Unplugged) return DeviceStatus::Disconnected;
		if (trouble != Frozen) m_sample = fresh;
		state = m_sample;
		if (trouble == Jumped) state.X_WH.translation.x += 0.1;
		if (trouble == NotFinite) state.X_WH.translation.y = kNaN;
		if (trouble == NotRigid) state.X_WH.rotation.m[1][1] = 3;
		if (trouble == TwistNotFinite) state.twist.angular.z = kInfinity;
		if (trouble == NotReady) state.flags &= ~static_cast<std::uint32_t>(kHandPresent);
		return status;
	}
	DeviceStatus write(const DeviceCommand& command) noexcept override
	{
		++m_invariants.writes;
		if (!isFinite(command.wrench)) ++m_invariants.notFinite;
		if (norm(command.wrench.force) > 1.000001 * info().peakForce || norm(command.wrench.torque) > 1.000001 * info().peakTorque)
			++m_invariants.tooLarge;
		if (command.gripForce != 0) ++m_invariants.grips;
		m_invariants.lastForce = norm(command.wrench.force) + norm(command.wrench.torque);
		const int trouble = m_trouble;
		if (trouble == Unplugged || trouble == WritesRefused) return DeviceStatus::Disconnected;
		return m_hand.write(command);
	}

private:
	SimulatedDevice m_hand;
	Invariants& m_invariants;
	std::atomic<int>& m_trouble;
	DeviceState m_sample;
};

class WildClock final : public Clock
{
public:
	std::atomic<std::int64_t> offset{0};
	std::int64_t now() const noexcept override { return m_clock.now() + offset; }
	void sleepUntil(std::int64_t deadline) noexcept override { m_clock.sleepUntil(deadline - offset); }

private:
	VirtualClock m_clock;
};

class WildSource final : public ContactSource
{
public:
	WildClock* clock = nullptr;
	std::atomic<int> mood{0};
	void advance(double, const DeviceState& hand, ToolStep& step) noexcept override
	{
		step.tool = {hand.X_WH, hand.twist};
		const double depth = std::max(0.0, -hand.X_WH.translation.z), stiffness = mood == 1 ? 1e9 : 900;
		step.coupling = {{0, 0, -stiffness * depth}, {0.02 * depth, 0, 0}};
		if (mood == 2) step.coupling.torque.y = kNaN;
		if (mood == 3) step.overdue = 12'000'000;
		if (mood == 4) clock->sleepUntil(clock->now() + 100'000'000), mood = 0;
		step.contactCount = depth > 0 ? 1 : 0;
		if (mood == 5) step.contactCount = 1000;
		if (mood == 6) step.contactCount = -7;
		if (depth > 0) step.contacts[0] = {{{0, 0, stiffness * depth}, {}}, hand.X_WH.translation, {0, 0, 1}, depth * 1e-4, 1, this};
	}
};

class WildLaw final : public ForceLaw
{
public:
	std::atomic<int> mood{0};
	ist::Wrench handWrench(const DeviceState&, const ToolStep& step) noexcept override
	{
		ist::Wrench wrench = -1.0 * step.coupling;
		if (mood == 1) wrench.force.x = kNaN;
		if (mood == 2) wrench.torque.x = -kInfinity;
		if (mood == 3) wrench = 1e300 * ist::Wrench{{1, 1, 1}, {1, 1, 1}};
		return wrench;
	}
	std::int64_t computedAt(const DeviceState& hand) const noexcept override
	{
		return mood == 4 ? hand.sampledAt - 50'000'000
			: mood == 5  ? hand.sampledAt + 1'000'000'000
			: mood == 6  ? INT64_MIN
						 : hand.sampledAt;
	}
};

class Fuzz
{
public:
	explicit Fuzz(unsigned seed) : m_random(seed)
	{
		m_source.clock = &m_clock;
		rebuild();
	}
	~Fuzz() { m_thread.reset(); }

	void operation()
	{
		switch (pick(16))
		{
		case 0: m_trouble = pick(SpiedDevice::Troubles); break;
		case 1: recover(); break;
		case 2: m_source.mood = pick(7); break;
		case 3: m_law.mood = pick(7); break;
		case 4: recover(); break;
		case 5: m_thread->enableForces(pick(3) > 0); break;
		case 6: pick(2) ? m_thread->raiseFault() : m_thread->clearFault(); break;
		case 7: m_thread->clearFault(); break;
		case 8: m_clock.offset += pick(2) ? 100'000'000 : -100'000'000; break;
		case 9: listen(); break;
		case 10: forget(); break;
		case 11: m_thread->setForceLaw(pick(3) == 0 ? nullptr : pick(2) ? static_cast<ForceLaw*>(&m_law) : &m_threaded); break;
		case 12: pick(2) ? m_threaded.setThreaded(pick(2)) : static_cast<void>(m_threaded.serve()); break;
		case 13:
			if (pick(60) == 0) rebuild();
			break;
		case 14:
			if (pick(60) == 0) openSomething();
			break;
		default:
			if (pick(150) == 0) runOnItsOwn();
			break;
		}
		tick();
	}

	Invariants invariants;
	std::uint64_t felt = 0;  ///< number of operations after which the hand felt a force
	std::uint64_t opened = 0, refused = 0, runs = 0;

private:
	int pick(int below) { return static_cast<int>(m_random() % static_cast<unsigned>(below)); }

	void tick()
	{
		const int ticks = 1 + pick(4);
		ASSERT_TRUE(m_thread->run(ticks));
		if (mustBeSilent())
		{
			// If a listener of onFault throws, the tick's command was already sent. The next tick is silent.
			ASSERT_TRUE(m_thread->run(1));
			if (mustBeSilent()) expectSilence();
		}
		felt += invariants.lastForce > 0;
	}

	bool mustBeSilent() const { return m_thread->faulted() || m_trouble == SpiedDevice::Unplugged || m_trouble == SpiedDevice::NotFinite; }

	/// A decorator that delays commands may still pass on an older one.
	void expectSilence()
	{
		if (m_delays) return;
		ASSERT_EQ(invariants.lastForce, 0) << "trouble " << m_trouble << ", faulted " << m_thread->faulted() << ", cause "
										   << describe(m_thread->faultCause()) << ", sent " << norm(m_thread->sentWrench().force)
										   << ", stack " << m_stack;
	}

	void recover()
	{
		m_trouble = SpiedDevice::None;
		m_source.mood = 0;
		m_law.mood = 0;
		m_thread->enableForces(true);
		m_thread->clearFault();
	}

	/// Builds a new thread with a random stack of decorators.
	void rebuild()
	{
		const bool had = m_thread != nullptr;
		m_thread.reset();
		if (had) expectSilence();
		m_listeners[0].clear(), m_listeners[1].clear(), m_listeners[2].clear(), m_listeners[3].clear();
		const char* const profiles[] = {"sigma7", "touch", "falcon", "omega3"};
		m_trouble = SpiedDevice::None;
		m_delays = false;
		m_stack.clear();
		std::unique_ptr<Device> device = std::make_unique<SpiedDevice>(simulatedProfile(profiles[pick(4)]).value(), invariants, m_trouble);
		for (int i = pick(4); i > 0; --i) switch (const int kind = pick(6); m_stack += std::to_string(kind), kind)
			{
			case 0: device = std::make_unique<MountedDevice>(std::move(device), ist::Pose{{}, {1, 2, 3}}, 0.5 + 0.5 * pick(4)); break;
			case 1: device = std::make_unique<ClutchedDevice>(std::move(device), 1U << pick(3)); break;
			case 2: device = std::make_unique<VelocityFilter>(std::move(device), 10.0 * pick(5), pick(2)); break;
			case 3: device = std::make_unique<DelayedDevice>(std::move(device), pick(3), pick(3)), m_delays = true; break;
			case 4: device = std::make_unique<RestrictedDevice>(std::move(device), kTranslation, kTranslation); break;
			default: device = std::make_unique<RecordingDevice>(std::move(device), 100); break;
			}
		m_device = std::move(device);
		m_device->open();
		SteppingSettings settings;
		settings.realTime = settings.lockMemory = false;
		settings.safety.passivity = pick(2);
		settings.safety.startInsideLatch = pick(2);
		settings.safety.oneFactor = pick(2);
		settings.safety.rampTime = pick(3) ? 5'000'000 : 500'000'000;
		m_thread = std::make_unique<SteppingThread>(*m_device, m_source, m_clock, settings);
		m_thread->setForceLaw(&m_law);
	}

	void listen()
	{
		const int event = pick(4), what = pick(8);
		if (m_listeners[event].size() > 6) return;
		const auto act = [this, what] {
			if (what == 0 && m_random() % 50 == 0) throw std::runtime_error("a hook");
			if (what == 1 && m_random() % 50 == 0) throw 7;
		};
		if (event == 0) m_listeners[0].push_back(m_thread->onTransform.addDelegate([act](const DeviceState&) { act(); }));
		if (event == 1) m_listeners[1].push_back(m_thread->onCollision.addDelegate([act](const ToolContact&) { act(); }));
		if (event == 2)
			m_listeners[2].push_back(m_thread->onHapticTick.addDelegate([act, what](const DeviceState&, ist::Wrench& wrench) {
				act();
				if (what == 2) wrench = 1e6 * wrench;
				if (what == 3) wrench.force.y += 0.5;
			}));
		if (event == 3) m_listeners[3].push_back(m_thread->onFault.addDelegate([act](const Fault&) { act(); }));
	}

	void forget()
	{
		const int event = pick(4);
		if (m_listeners[event].empty()) return;
		const std::uint64_t id = m_listeners[event].back();
		m_listeners[event].pop_back();
		const bool removed = event == 0 ? m_thread->onTransform.removeDelegate(id)
			: event == 1                ? m_thread->onCollision.removeDelegate(id)
			: event == 2                ? m_thread->onHapticTick.removeDelegate(id)
										: m_thread->onFault.removeDelegate(id);
		ASSERT_TRUE(removed);
	}

	void openSomething()
	{
		const char* const addresses[] = {"sim:sigma7", "sim:touch?dof=3", "sim:touch?dof=6", "sim:omega6?sense=3", "sim:", "sim:none",
			"none:1", "", ":", "replay:no-such-file.csv", "sim:sigma7?dof=9", "own:x", "sim:sigma7?reconnect=maybe"};
		const auto device = m_registry.open(addresses[pick(13)]);
		device ? ++opened : ++refused;
		ASSERT_TRUE(device || !device.error().message.empty());
		if (pick(4) == 0)
			m_registry.addScheme("own", [](const std::string&) -> ist::Result<std::unique_ptr<Device>> {
				return ist::Error{"nothing there", false};
			});
	}

	/// Runs the thread by itself for a moment, while this thread calls what any thread may call.
	void runOnItsOwn()
	{
		// Listeners are removed, because random numbers drawn in them would be drawn by two threads.
		for (int event = 0; event < 4; ++event)
			while (!m_listeners[event].empty())
			{
				const std::uint64_t id = m_listeners[event].back();
				m_listeners[event].pop_back();
				m_thread->onTransform.removeDelegate(event == 0 ? id : 0);
				m_thread->onCollision.removeDelegate(event == 1 ? id : 0);
				m_thread->onHapticTick.removeDelegate(event == 2 ? id : 0);
				m_thread->onFault.removeDelegate(event == 3 ? id : 0);
			}
		const bool threaded = pick(2);
		if (threaded)
		{
			m_thread->setForceLaw(&m_threaded);
			ASSERT_TRUE(m_threaded.start());
		}
		// The loop runs on its own thread, or in run() on a thread of the program.
		std::thread runner;
		if (pick(2))
		{
			ASSERT_TRUE(m_thread->start());
		}
		else runner = std::thread([this] { m_thread->run(INT64_MAX); });
		while (!m_thread->running()) std::this_thread::yield();
		EXPECT_FALSE(m_thread->run(1));
		EXPECT_FALSE(m_thread->start());
		EXPECT_NE(m_thread->refusal()[0], '\0');
		++runs;
		for (int i = 0; i < 20; ++i)
		{
			m_thread->enableForces(pick(2));
			pick(2) ? m_thread->raiseFault() : m_thread->clearFault();
			m_trouble = pick(SpiedDevice::Troubles);
			m_source.mood = pick(4);
			m_law.mood = pick(7);
			m_threaded.setThreaded(pick(2));
			static_cast<void>(m_thread->energy());
			static_cast<void>(m_thread->safetyCounts().total() + m_thread->faults());
			static_cast<void>(m_thread->periods().quantile(0.5));
			std::this_thread::sleep_for(std::chrono::microseconds(100));
		}
		m_trouble = SpiedDevice::None;
		if (pick(2)) m_thread->requestStop();
		m_thread->stop();
		if (runner.joinable()) runner.join();
		m_threaded.stop();
		ASSERT_FALSE(m_thread->running());
		expectSilence();
		m_thread->enableForces(true);
		m_thread->clearFault();
		m_source.mood = 0, m_law.mood = 0;
	}

	std::mt19937 m_random;
	WildClock m_clock;
	WildSource m_source;
	WildLaw m_law;
	ThreadedForceLaw m_threaded{m_law};
	std::atomic<int> m_trouble{0};
	bool m_delays = false;
	std::string m_stack;
	DeviceRegistry m_registry;
	std::unique_ptr<Device> m_device;
	std::unique_ptr<SteppingThread> m_thread;
	std::vector<std::uint64_t> m_listeners[4];
};

long operations()
{
	const char* wanted = std::getenv("DEVICEBRIDGE_FUZZ_OPERATIONS");
	return wanted ? std::max(1L, std::atol(wanted)) : 100'000;
}
}  // namespace

// The random numbers are seeded, so a failure is reproducible up to the first time that the thread ran by itself (runOnItsOwn). Then real
// time determines clock, device and law. For a longer run set DEVICEBRIDGE_FUZZ_OPERATIONS=10000000.
TEST(OperationFuzz, NoSequenceOfOperationsBreaksAnInvariant)
{
	const long all = operations(), each = 10'000;
	std::uint64_t felt = 0, opened = 0, refused = 0, runs = 0;
	for (long done = 0, seed = 1; done < all; done += each, ++seed)
	{
		SCOPED_TRACE("seed " + std::to_string(seed));
		Fuzz fuzz(static_cast<unsigned>(seed));
		for (long i = 0; i < std::min(each, all - done); ++i)
		{
			fuzz.operation();
			if (testing::Test::HasFatalFailure()) FAIL() << "operation " << i;
		}
		EXPECT_EQ(fuzz.invariants.notFinite, 0U);
		EXPECT_EQ(fuzz.invariants.tooLarge, 0U);
		EXPECT_EQ(fuzz.invariants.grips, 0U);
		felt += fuzz.felt, opened += fuzz.opened, refused += fuzz.refused, runs += fuzz.runs;
	}
	// These counts show that the operations had an effect.
	if (all < 100'000) return;
	EXPECT_GT(felt, 5000U);
	EXPECT_GT(opened, 10U);
	EXPECT_GT(refused, 10U);
	EXPECT_GT(runs, 10U);
}
