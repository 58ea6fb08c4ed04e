// SPDX-License-Identifier: Zlib
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <thread>

#include "DeviceBridge/Loop/ForceLaw.h"
#include "DeviceBridge/Loop/GapBridge.h"
#include "DeviceBridge/Safety/FaultCause.h"
#include "DeviceBridge/Safety/SafetyLimiter.h"
#include "DeviceBridge/Safety/SampleMonitor.h"
#include "DeviceBridge/Timing/Clock.h"
#include "DeviceBridge/Timing/Delegate.h"
#include "DeviceBridge/Timing/SteadyTime.h"

namespace devicebridge
{
/// Durations, four bins to the octave. One thread adds, any thread reads.
class DurationHistogram
{
public:
	void add(std::int64_t nanoseconds) noexcept;
	std::uint64_t count() const noexcept { return m_count.load(std::memory_order_relaxed); }
	std::int64_t longest() const noexcept { return m_longest.load(std::memory_order_relaxed); }
	/// Upper edge of the bin below which the share `p` of all durations lies [ns], at most 19 % above the true quantile.
	double quantile(double p) const noexcept;

private:
	static constexpr int kBins = 160;
	std::array<std::atomic<std::uint64_t>, kBins> m_bins{};
	std::atomic<std::uint64_t> m_count{0};
	std::atomic<std::int64_t> m_longest{0};
};

struct SteppingSettings
{
	std::int64_t period = 1'000'000;  ///< [ns]
	bool realTime = true;             ///< ask for SCHED_FIFO in start()
	/// Ask in start() that no page of the process is swapped out, now or later. It holds for the whole program and stays so: every thread's
	/// stack and every mapped file become resident. Set it where the haptic loop is what the program is for.
	bool lockMemory = false;
	int priority = 80;  ///< of SCHED_FIFO; below 99, where the watchdogs of the kernel live
	SafetySettings safety;
	SampleMonitorSettings watch;
};

/// The haptic loop. One tick: read the device, onTransform, ContactSource, onCollision for each contact, ForceLaw,
/// onHapticTick, SafetyLimiter, write the device. Of itself a tick allocates nothing and takes no lock; what its source does, that says.
/// After a gap between ticks the schedule begins anew, the world takes one step of the nominal period, and the tool follows the hand as
/// GapBridge says; so it does after an outage of the device and after stop() and start().
/// Device, source, law and clock outlive the thread. Set up listeners and law before start(). What a listener throws ends at
/// the tick: the device gets zero until clearFault().
class SteppingThread
{
public:
	SteppingThread(Device& device, ContactSource& source, Clock& clock, const SteppingSettings& settings = {});
	~SteppingThread();
	SteppingThread(const SteppingThread&) = delete;
	SteppingThread& operator=(const SteppingThread&) = delete;

	/// Null restores the CouplingForceLaw.
	void setForceLaw(ForceLaw* law) noexcept { m_law = law ? law : &m_couplingLaw; }

	/// Ticks on the calling thread, as many or until a stop, and is running() meanwhile. False, with a refusal(), while a loop runs.
	/// After its last tick the device keeps the last command until that expires, so that the next run() goes on from there. A stop
	/// leaves it at zero.
	bool run(std::int64_t ticks) noexcept;
	/// Ticks on an own thread until a stop. False, with a refusal(), when the loop runs already or cannot be started.
	bool start();
	/// Waits for the tick in progress, in run() too, and leaves the device at zero. From a listener, which is on the tick, it is
	/// requestStop(). Not while another thread is in start(), stop() or the destructor. A run() that begins later is not stopped.
	void stop() noexcept;
	/// Ends the loop after the tick in progress, without waiting. While no loop runs it does nothing: the next one is not stopped.
	/// From any thread and from a signal handler.
	void requestStop() noexcept;
	bool running() const noexcept { return m_loop.load(std::memory_order_acquire) != Loop::Idle; }
	/// Why the last start() or run() did nothing, in a sentence; empty when it did.
	const char* refusal() const noexcept { return m_refusal.load(std::memory_order_relaxed); }

	Delegate<const DeviceState> onTransform;
	Delegate<const ToolContact> onCollision;
	/// The wrench for the hand, to be read or changed before the safety limits.
	Delegate<const DeviceState, ist::Wrench> onHapticTick;

	/// The force went to zero for a cause that was not there the tick before. On the tick.
	Delegate<const Fault> onFault;

	// From any thread, at any time:
	/// Off: zero. On again: from zero along the ramp, and not before the tool is free.
	void enableForces(bool on) noexcept { m_limiter.enable(on); }
	/// As if a listener had thrown: zero until clearFault().
	void raiseFault() noexcept { m_limiter.raiseFault(); }
	/// Of the last tick; None: nothing held the device at zero.
	FaultCause faultCause() const noexcept { return m_cause.load(std::memory_order_relaxed); }
	/// How often onFault was called.
	std::uint64_t faults() const noexcept { return m_faults.load(std::memory_order_relaxed); }
	/// How often the clock ran backwards.
	std::uint64_t clockJumps() const noexcept { return m_time.jumps(); }
	/// What the passivity controller has seen.
	EnergyLog energy() const noexcept { return m_limiter.energy(); }
	/// SafetyLimiter::heatLoad().
	double heatLoad() const noexcept { return m_limiter.heatLoad(); }
	std::uint64_t ticks() const noexcept { return m_ticks.load(std::memory_order_relaxed); }
	/// Ticks that began later than one period after their deadline.
	std::uint64_t overruns() const noexcept { return m_overruns.load(std::memory_order_relaxed); }
	/// Reads without a sample to act on, and writes that failed.
	std::uint64_t deviceErrors() const noexcept { return m_deviceErrors.load(std::memory_order_relaxed); }
	/// From the beginning of a tick to that of the next.
	const DurationHistogram& periods() const noexcept { return m_periods; }
	/// From the beginning of a tick to its end.
	const DurationHistogram& costs() const noexcept { return m_costs; }
	SafetyCounts safetyCounts() const noexcept { return m_limiter.counts(); }
	bool faulted() const noexcept { return m_limiter.faulted(); }
	void clearFault() noexcept { m_limiter.clearFault(); }
	/// How the system schedules the loop, in words.
	const char* scheduling() const noexcept { return m_scheduling.load(std::memory_order_relaxed); }
	/// Whether its memory is locked, in words.
	const char* memory() const noexcept { return m_memory.load(std::memory_order_relaxed); }

	// From a listener, or while nothing runs:
	/// The last good sample.
	const DeviceState& state() const noexcept { return m_state; }
	/// What the world gave in the last tick.
	const ToolStep& step() const noexcept { return m_step; }
	/// On the hand, about the origin of H, in W: as the force law and the listeners wanted it; zero without a sample to act on.
	const ist::Wrench& wantedWrench() const noexcept { return m_wanted; }
	/// The same as it went to the device; zero where that did not take it.
	const ist::Wrench& sentWrench() const noexcept { return m_sent.wrench; }

private:
	enum class Loop
	{
		Idle,
		Running,
		Stopping  ///< after the tick in progress
	};
	bool claim() noexcept;
	void leave() noexcept;
	void loop(std::int64_t ticks) noexcept;
	void waitForTick() noexcept;
	void tick() noexcept;
	bool readDevice(std::int64_t now) noexcept;
	std::int64_t computeWrench();
	void advanceWorld();
	void send(std::int64_t computedAt) noexcept;
	void sendZero(FaultCause cause, std::int64_t at) noexcept;
	void report(FaultCause cause, bool latched) noexcept;
	void askForRealTime() noexcept;
	void askForMemory() noexcept;

	Device& m_device;
	ContactSource& m_source;
	SteadyTime m_time;
	GapBridge m_gapBridge;
	SteppingSettings m_settings;
	SafetyLimiter m_limiter;
	SampleMonitor m_watch;
	CouplingForceLaw m_couplingLaw;
	ForceLaw* m_law = &m_couplingLaw;

	DeviceState m_state;
	ToolStep m_step;
	ist::Wrench m_wanted;
	DeviceCommand m_sent;
	std::uint64_t m_sequence = 0;
	std::int64_t m_deadline = 0, m_lastTick = 0, m_lastSampleTick = 0;
	std::int64_t m_outageSince = 0;
	std::uint64_t m_seenJumps = 0;
	FaultCause m_watchCause = FaultCause::None, m_latchedCause = FaultCause::None;
	bool m_scheduled = false;
	bool m_hasState = false, m_outage = false;

	std::thread m_thread;
	std::atomic<std::thread::id> m_loopThread{};
	std::atomic<Loop> m_loop{Loop::Idle};
	std::atomic<std::uint64_t> m_stops{0};  // loops that a stop has ended
	static_assert(std::atomic<Loop>::is_always_lock_free, "a signal handler changes it");
	std::atomic<const char*> m_refusal{""};
	std::atomic<std::uint64_t> m_ticks{0}, m_overruns{0}, m_deviceErrors{0}, m_faults{0};
	std::atomic<FaultCause> m_cause{FaultCause::None};
	std::atomic<const char*> m_scheduling, m_memory;
	DurationHistogram m_periods, m_costs;
};
}  // namespace devicebridge
