// SPDX-License-Identifier: Zlib
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "DeviceBridge/Loop/ForceLaw.h"
#include "DeviceBridge/Loop/GapBridge.h"
#include "DeviceBridge/Safety/FaultCause.h"
#include "DeviceBridge/Safety/SafetyLimiter.h"
#include "DeviceBridge/Safety/SampleMonitor.h"
#include "DeviceBridge/Timing/Clock.h"
#include "DeviceBridge/Timing/Delegate.h"
#include "DeviceBridge/Timing/MonotonicClock.h"

namespace devicebridge
{
/// Histogram of durations, four bins per octave. One thread adds, any thread reads.
class DurationHistogram
{
public:
	void add(std::int64_t nanoseconds) noexcept;
	std::uint64_t count() const noexcept { return m_count.load(std::memory_order_relaxed); }
	std::int64_t longest() const noexcept { return m_longest.load(std::memory_order_relaxed); }
	/// Upper edge of the bin below which the share `p` of all durations lies [ns]; at most 19 % above the true quantile.
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
	bool realTime = true;             ///< whether start() requests SCHED_FIFO
	/// Whether start() asks that no page of the process is ever swapped out. This holds for the whole program and is never undone: every
	/// thread's stack and every mapped file become resident. Set it in a program whose main purpose is the haptic loop.
	bool lockMemory = false;
	int priority = 80;  ///< priority under SCHED_FIFO; below 99, which the kernel's watchdogs use
	SafetySettings safety;
	SampleMonitorSettings monitor;
};

/// The haptic loop. One tick: read the device, onTransform, ContactSource, onCollision for each contact, ForceLaw, onHapticTick,
/// SafetyLimiter, write the device. The tick itself allocates nothing and takes no lock; the source documents its own cost.
/// After a gap between ticks the schedule starts again, the world takes one step of the nominal period, and GapBridge brings the tool to
/// the hand. The same happens after an outage of the device and after stop() and start().
/// Hands that share a world have one loop (addHand).
/// Device, source, law and clock must outlive the thread. Set up listeners and law before start(). If a listener throws, the tick catches
/// it, and the device gets zero until clearFault().
class SteppingThread
{
public:
	SteppingThread(Device& device, ContactSource& source, Clock& clock, const SteppingSettings& settings = {});
	~SteppingThread();
	SteppingThread(const SteppingThread&) = delete;
	SteppingThread& operator=(const SteppingThread&) = delete;

	/// Null restores the CouplingForceLaw.
	void setForceLaw(ForceLaw* law) noexcept { m_law = law ? law : &m_couplingLaw; }

	/// Adds the hand of `other` to this loop, for sources that share a world which this thread owns. In each tick all hands are read and
	/// pull their tools. Then the sources advance, this one first, and each hand gets its force. `other` has no loop of its own from now
	/// on: its run() and start() are refused, and its stop() and requestStop() act on this loop, whose overruns, periods and costs are
	/// those of all. Call it while neither loop runs; it allocates. Returns an empty text, or a sentence that says why it was refused: a
	/// loop itself, one that runs, one with another period, or one that shares already.
	const char* addHand(SteppingThread& other);

	/// Runs ticks on the calling thread, up to `ticks` or until a stop; running() is true meanwhile. Returns false, with a refusal(), while
	/// a loop runs. After the last tick the device keeps the last command until it expires, so that the next run() can continue. After a
	/// stop the device is at zero.
	bool run(std::int64_t ticks) noexcept;
	/// Runs ticks on a separate thread until a stop. Returns false, with a refusal(), if the loop runs already or cannot be started.
	bool start();
	/// Stops the loop, also in run(): waits for the tick in progress and leaves the device at zero. In a listener, which runs in the tick,
	/// it acts as requestStop(). Do not call it while another thread is in start(), stop() or the destructor. A run() that begins later is
	/// not stopped.
	void stop() noexcept;
	/// Ends the loop after the tick in progress, without waiting. Without a running loop it does nothing, so the next loop is not stopped.
	/// Any thread and any signal handler may call it.
	void requestStop() noexcept;
	bool running() const noexcept { return owner().m_loop.load(std::memory_order_acquire) != Loop::Idle; }
	/// A sentence that says why the last start() or run() was refused; empty if it was not.
	const char* refusal() const noexcept { return m_refusal.load(std::memory_order_relaxed); }

	Delegate<const DeviceState> onTransform;
	Delegate<const ToolContact> onCollision;
	/// Event with the wrench for the hand, which a listener may read or change before the safety limits.
	Delegate<const DeviceState, ist::Wrench> onHapticTick;

	/// Event after the force went to zero for a cause that was absent in the tick before. It is raised in the tick.
	Delegate<const Fault> onFault;

	// For any thread, at any time:
	/// Off: the force is zero. On again: the force rises from zero along the ramp, once the tool is free.
	void enableForces(bool on) noexcept { m_limiter.enable(on); }
	/// Acts as if a listener had thrown: the force is zero until clearFault().
	void raiseFault() noexcept { m_limiter.raiseFault(); }
	/// Cause of zero force in the last tick; None if there was none.
	FaultCause faultCause() const noexcept { return m_cause.load(std::memory_order_relaxed); }
	/// Number of calls of onFault.
	std::uint64_t faults() const noexcept { return m_faults.load(std::memory_order_relaxed); }
	/// Number of times that the clock ran backwards.
	std::uint64_t clockJumps() const noexcept { return m_time.jumps(); }
	/// Energies that the passivity controller has measured.
	EnergyLog energy() const noexcept { return m_limiter.energy(); }
	/// SafetyLimiter::heatLoad().
	double heatLoad() const noexcept { return m_limiter.heatLoad(); }
	std::uint64_t ticks() const noexcept { return m_ticks.load(std::memory_order_relaxed); }
	/// Number of ticks that began later than one period after their deadline.
	std::uint64_t overruns() const noexcept { return owner().m_overruns.load(std::memory_order_relaxed); }
	/// Number of reads without a usable sample, plus the number of failed writes.
	std::uint64_t deviceErrors() const noexcept { return m_deviceErrors.load(std::memory_order_relaxed); }
	/// Durations from the beginning of one tick to the beginning of the next.
	const DurationHistogram& periods() const noexcept { return owner().m_periods; }
	/// Durations from the beginning of a tick to its end.
	const DurationHistogram& costs() const noexcept { return owner().m_costs; }
	SafetyCounts safetyCounts() const noexcept { return m_limiter.counts(); }
	bool faulted() const noexcept { return m_limiter.faulted(); }
	void clearFault() noexcept { m_limiter.clearFault(); }
	/// How the system schedules the loop, in words.
	const char* scheduling() const noexcept { return owner().m_scheduling.load(std::memory_order_relaxed); }
	/// Whether the process's memory is locked, in words.
	const char* memory() const noexcept { return owner().m_memory.load(std::memory_order_relaxed); }

	// For a listener, or while no loop runs:
	/// The last good sample.
	const DeviceState& state() const noexcept { return m_state; }
	/// Result of the world's step in the last tick.
	const ToolStep& step() const noexcept { return m_step; }
	/// Wrench on the hand, about the origin of H, in W, as the force law and the listeners computed it; zero without a usable sample.
	const ist::Wrench& wantedWrench() const noexcept { return m_wanted; }
	/// The same wrench as it was sent to the device; zero if the device did not accept it.
	const ist::Wrench& sentWrench() const noexcept { return m_sent.wrench; }

private:
	enum class Loop
	{
		Idle,
		Running,
		Stopping  ///< the loop ends after the tick in progress
	};
	/// The loop that ticks this hand.
	const SteppingThread& owner() const noexcept { return m_owner ? *m_owner : *this; }
	bool claim() noexcept;
	void leave() noexcept;
	void loop(std::int64_t ticks) noexcept;
	void waitForTick() noexcept;
	void tick() noexcept;
	void beginTick() noexcept;
	void endTick() noexcept;
	bool readDevice(std::int64_t now) noexcept;
	void prepareWorld();
	std::int64_t computeWrench();
	void advanceWorld();
	void sendZeroAfterException() noexcept;
	void send(std::int64_t computedAt) noexcept;
	void sendZero(FaultCause cause, std::int64_t at) noexcept;
	void report(FaultCause cause, bool latched) noexcept;
	void askForRealTime() noexcept;
	void askForMemory() noexcept;

	Device& m_device;
	ContactSource& m_source;
	MonotonicClock m_time;
	GapBridge m_gapBridge;
	SteppingSettings m_settings;
	SafetyLimiter m_limiter;
	SampleMonitor m_monitor;
	CouplingForceLaw m_couplingLaw;
	ForceLaw* m_law = &m_couplingLaw;

	std::vector<SteppingThread*> m_hands;  // hands that were added
	SteppingThread* m_owner = nullptr;     // the loop to which this hand was added; null: this one

	DeviceState m_state;
	DeviceState m_pulling;  // the sample with which the source was prepared
	ToolStep m_step;
	ist::Wrench m_wanted;
	DeviceCommand m_sent;
	std::uint64_t m_sequence = 0;
	std::int64_t m_deadline = 0, m_lastTick = 0, m_lastSampleTick = 0;
	std::int64_t m_outageSince = 0, m_refusesSince = 0;
	std::uint64_t m_seenJumps = 0;
	FaultCause m_monitorCause = FaultCause::None, m_latchedCause = FaultCause::None;
	bool m_scheduled = false;
	bool m_hasState = false, m_outage = false;
	bool m_isFresh = false, m_threw = false;  // of the tick in progress: there is a usable sample; a listener has thrown
	bool m_refuses = false;                   // the device, the last command

	std::thread m_thread;
	std::atomic<std::thread::id> m_loopThread{};
	std::atomic<Loop> m_loop{Loop::Idle};
	std::atomic<std::uint64_t> m_stops{0};  // number of loops that a stop has ended
	static_assert(std::atomic<Loop>::is_always_lock_free, "a signal handler changes it");
	std::atomic<const char*> m_refusal{""};
	std::atomic<std::uint64_t> m_ticks{0}, m_overruns{0}, m_deviceErrors{0}, m_faults{0};
	std::atomic<FaultCause> m_cause{FaultCause::None};
	std::atomic<const char*> m_scheduling, m_memory;
	DurationHistogram m_periods, m_costs;
};
}  // namespace devicebridge
