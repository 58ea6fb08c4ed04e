// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Loop/SteppingThread.h"

#include "DeviceBridge/Platform/RealTimePriority.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>

namespace devicebridge
{
namespace
{
constexpr std::int64_t kHour = 3'600'000'000'000;    // [ns]
constexpr std::chrono::microseconds kPatience{200};  // interval between two requests to a loop that is to stop
constexpr const char* kOnTheCaller = "on the caller's thread, as that is scheduled";

bool isZero(const ist::Wrench& w) { return w.force == ist::Vec3() && w.torque == ist::Vec3(); }

void increment(std::atomic<std::uint64_t>& counter) { counter.fetch_add(1, std::memory_order_relaxed); }

// A camera or a glove that samples at 60 Hz is not frozen between two samples.
SampleMonitorSettings monitorOf(const DeviceInfo& info, SampleMonitorSettings settings)
{
	const double threePeriods = info.nominalRate > 0 ? 3e9 / info.nominalRate : 0;
	settings.frozenAfter = std::max(settings.frozenAfter, static_cast<std::int64_t>(std::min(threePeriods, 1e9)));
	const bool trembles = !info.turnsInPlace && (info.actuated & kTranslation) == kTranslation;
	if (info.scale > 0)
		for (double* limit : {&settings.longestJump, &settings.speed, &settings.movingSpeed}) *limit *= info.scale;
	if (settings.longestTurnInPlace == 0 && trembles) settings.longestTurnInPlace = 0.5;
	return settings;
}
}  // namespace

void DurationHistogram::add(std::int64_t nanoseconds) noexcept
{
	const double octaves = std::log2(static_cast<double>(std::max<std::int64_t>(1, nanoseconds)));
	increment(m_bins[static_cast<std::size_t>(std::clamp(static_cast<int>(4 * octaves), 0, kBins - 1))]);
	increment(m_count);
	if (nanoseconds > longest()) m_longest.store(nanoseconds, std::memory_order_relaxed);
}

double DurationHistogram::quantile(double p) const noexcept
{
	const double wanted = p * static_cast<double>(count());
	double below = 0;
	for (int i = 0; i < kBins; ++i)
	{
		below += static_cast<double>(m_bins[static_cast<std::size_t>(i)].load(std::memory_order_relaxed));
		if (below > 0 && below >= wanted) return std::exp2((i + 1) / 4.0);
	}
	return 0;
}

SteppingThread::SteppingThread(Device& device, ContactSource& source, Clock& clock, const SteppingSettings& settings)
	: m_device(device),
	  m_source(source),
	  m_time(clock),
	  m_settings(settings),
	  m_limiter(device.info(), settings.safety),
	  m_monitor(monitorOf(device.info(), settings.monitor)),
	  m_scheduling(kOnTheCaller),
	  m_memory("not locked: the loop has no thread of its own")
{
	m_settings.period = std::max<std::int64_t>(1, settings.period);
}

SteppingThread::~SteppingThread()
{
	stop();
	for (SteppingThread* hand : m_hands) hand->m_owner = nullptr;
	if (m_owner) m_owner->m_hands.erase(std::remove(m_owner->m_hands.begin(), m_owner->m_hands.end(), this), m_owner->m_hands.end());
	if (m_ticks > 0) sendZero(FaultCause::None, m_time.now());
}

const char* SteppingThread::addHand(SteppingThread& other)
{
	if (&other == this) return "a loop cannot be added to itself";
	if (running() || other.running()) return "a loop runs: stop it first";
	if (m_owner || other.m_owner || !other.m_hands.empty()) return "a loop shares its ticks already";
	if (m_settings.period != other.m_settings.period) return "the loops have different periods, but hands in one world share its step";
	m_hands.push_back(&other);
	other.m_owner = this;
	return "";
}

/// Gives the calling thread the sole right to tick. Returns false, with a refusal, if it cannot.
bool SteppingThread::claim() noexcept
{
	const char* refused = m_source.refusal();
	if (m_owner) refused = "the loop to which this hand was added ticks it: start that one";
	for (const SteppingThread* hand : m_hands)
		if (refused[0] == '\0') refused = hand->m_source.refusal();
	Loop idle = Loop::Idle;
	if (refused[0] == '\0' && !m_loop.compare_exchange_strong(idle, Loop::Running))
		refused = m_loopThread.load() == std::this_thread::get_id() ? "the loop runs on this very thread: a listener cannot start another"
																	: "the loop runs already, in start() or run(): stop() it first";
	m_refusal.store(refused, std::memory_order_relaxed);
	return refused[0] == '\0';
}

/// If a stop was requested during the last tick, sends zero.
void SteppingThread::leave() noexcept
{
	m_loopThread = std::thread::id();
	Loop running = Loop::Running;
	if (m_loop.compare_exchange_strong(running, Loop::Idle)) return;
	sendZero(FaultCause::None, m_time.now());
	for (SteppingThread* hand : m_hands) hand->sendZero(FaultCause::None, hand->m_time.now());
	m_scheduled = false;
	m_stops.fetch_add(1, std::memory_order_release);
	m_loop.store(Loop::Idle, std::memory_order_release);
}

void SteppingThread::loop(std::int64_t ticks) noexcept
{
	m_loopThread = std::this_thread::get_id();
	for (std::int64_t i = 0; i < ticks && m_loop.load(std::memory_order_acquire) == Loop::Running; ++i)
	{
		waitForTick();
		tick();
	}
	leave();
}

bool SteppingThread::run(std::int64_t ticks) noexcept
{
	if (!claim()) return false;
	m_scheduling = kOnTheCaller;
	loop(ticks);
	return true;
}

bool SteppingThread::start()
{
	if (!claim()) return false;
	if (m_thread.joinable()) m_thread.join();
	m_scheduled = false;
	try
	{
		m_thread = std::thread([this] {
			askForRealTime();
			askForMemory();
			loop(std::numeric_limits<std::int64_t>::max());
		});
	}
	catch (const std::exception&)
	{
		m_refusal = "the system gives no thread for the loop";
		m_loop = Loop::Idle;
		return false;
	}
	return true;  // the loop may have ended already
}

void SteppingThread::requestStop() noexcept
{
	if (m_owner) return m_owner->requestStop();
	Loop running = Loop::Running;
	m_loop.compare_exchange_strong(running, Loop::Stopping);
}

void SteppingThread::stop() noexcept
{
	if (m_owner) return m_owner->stop();
	const std::uint64_t stops = m_stops.load(std::memory_order_acquire);
	requestStop();
	if (m_loopThread.load() == std::this_thread::get_id()) return;
	if (m_thread.joinable()) m_thread.join();
	// A run() on another thread cannot be joined. This caller is not in a tick, so it may sleep. A run() that began between two of these
	// requests is stopped, too. A run() that begins after a loop was stopped is not waited for.
	for (; running() && m_stops.load(std::memory_order_acquire) == stops; std::this_thread::sleep_for(kPatience)) requestStop();
	Loop idle = Loop::Idle;
	if (!m_loop.compare_exchange_strong(idle, Loop::Stopping)) return;
	// A run() that ended by itself has left the last command active.
	if (!isZero(m_sent.wrench)) sendZero(FaultCause::None, m_time.now());
	for (SteppingThread* hand : m_hands)
		if (!isZero(hand->m_sent.wrench)) hand->sendZero(FaultCause::None, hand->m_time.now());
	m_scheduled = false;
	m_loop.store(Loop::Idle, std::memory_order_release);
}

void SteppingThread::askForRealTime() noexcept
{
	m_scheduling = m_settings.realTime ? askForRealTimePriority(m_settings.priority).words : "normal priority: real time was not asked for";
}

void SteppingThread::askForMemory() noexcept
{
	m_memory = m_settings.lockMemory ? askForLockedMemory().words : "not locked: it was not asked for";
}

void SteppingThread::waitForTick() noexcept
{
	if (!m_scheduled)
	{
		m_deadline = m_lastTick = m_time.now();
		m_scheduled = true;
	}
	m_deadline += m_settings.period;
	m_time.sleepUntil(m_deadline);
	const std::int64_t now = m_time.now();
	m_periods.add(now - m_lastTick);
	m_lastTick = now;
	// After a jump back the sleep may have ended early as well, so the schedule starts again.
	if (m_time.jumps() != m_seenJumps) m_deadline = now;
	if (now - m_deadline <= m_settings.period) return;
	// Missed ticks are dropped, because catching up would send a burst of force updates with no time between them.
	increment(m_overruns);
	m_deadline = now;
}

void SteppingThread::tick() noexcept
{
	const std::int64_t now = m_lastTick;
	for (SteppingThread* hand : m_hands) hand->m_lastTick = hand->m_time.now();
	beginTick();
	for (SteppingThread* hand : m_hands) hand->beginTick();
	endTick();
	for (SteppingThread* hand : m_hands) hand->endTick();
	increment(m_ticks);
	for (SteppingThread* hand : m_hands) increment(hand->m_ticks);
	m_costs.add(m_time.now() - now);
}

/// Reads the device and pulls the tool. All hands of a loop do this before their world takes a step.
void SteppingThread::beginTick() noexcept
{
	m_isFresh = readDevice(m_lastTick);
	m_wanted = {};
	m_threw = false;
	try
	{
		if (m_isFresh) onTransform.broadcast(m_state);
		if (m_hasState) prepareWorld();
	}
	catch (...)
	{
		m_threw = true;
	}
}

void SteppingThread::endTick() noexcept
{
	if (m_threw) return sendZeroAfterException();
	try
	{
		const std::int64_t computedAt = m_isFresh ? computeWrench() : m_lastTick;
		if (!m_isFresh && m_hasState) advanceWorld();
		if (m_isFresh) send(computedAt);
		else sendZero(m_monitorCause, m_lastTick);
	}
	catch (...)
	{
		sendZeroAfterException();
	}
}

void SteppingThread::sendZeroAfterException() noexcept
{
	m_limiter.raiseFault();
	m_latchedCause = FaultCause::HookException;
	sendZero(FaultCause::HookException, m_lastTick);
}

std::int64_t SteppingThread::computeWrench()
{
	advanceWorld();
	m_wanted = m_law->handWrench(m_state, m_step);
	// The time that a law reports is limited to an hour from now. Beyond that all answers are equally old, and sums with such times would
	// overflow.
	const std::int64_t saidAt = std::clamp(m_law->computedAt(m_state), m_lastTick - kHour, m_lastTick + kHour);
	const std::int64_t computedAt = saidAt - std::clamp<std::int64_t>(m_step.overdue, 0, kHour);
	onHapticTick.broadcast(m_state, m_wanted);
	return computedAt;
}

/// Returns false if there is no usable sample. Then the last good one stays, and `m_monitorCause` says why.
bool SteppingThread::readDevice(std::int64_t now) noexcept
{
	DeviceState state = m_state;
	const DeviceStatus status = m_device.read(now, state);
	m_monitorCause = status == DeviceStatus::Ok ? m_monitor.judge(state, now)
		: status == DeviceStatus::InvalidState  ? FaultCause::InvalidState
												: FaultCause::Disconnected;
	if (m_monitorCause == FaultCause::InvalidState)
	{
		m_limiter.raiseFault();
		m_latchedCause = FaultCause::InvalidState;
	}
	if (m_monitorCause != FaultCause::None)
	{
		if (!m_outage) m_outageSince = now;
		m_outage = true;
		increment(m_deviceErrors);
		return false;
	}
	// The slew limit bridges a short outage. After a longer one the hand may be anywhere.
	if (m_outage && now - m_outageSince > m_settings.safety.fullUntil) m_limiter.restart();
	m_outage = false;
	m_state = state;
	m_hasState = true;
	return true;
}

void SteppingThread::prepareWorld()
{
	m_pulling = m_state;
	// The hand also moves on while the device gives no sample and while the thread is stopped.
	m_pulling.X_WH = m_gapBridge.reference(
		m_state.X_WH, 1e-9 * static_cast<double>(m_lastTick - m_lastSampleTick), 1e-9 * static_cast<double>(m_settings.period));
	if (m_monitorCause == FaultCause::None) m_lastSampleTick = m_lastTick;
	else m_pulling.flags &= ~static_cast<std::uint32_t>(kHandPresent);
	m_source.prepare(1e-9 * static_cast<double>(m_settings.period), m_pulling);
}

// Uses the nominal period, because a late tick must not make the world take a longer, less stable step.
void SteppingThread::advanceWorld()
{
	m_step.contactCount = 0;
	m_step.overlapVolume = 0;
	m_step.pairs = 0;
	m_step.overdue = 0;
	m_step.toolIsBroken = false;
	m_source.advance(1e-9 * static_cast<double>(m_settings.period), m_pulling, m_step);
	if (m_step.toolIsBroken)
	{
		m_limiter.raiseFault();
		m_latchedCause = FaultCause::ToolNotFinite;
	}
	m_step.contactCount = std::clamp(m_step.contactCount, 0, kMaxToolContacts);
	for (int i = 0; i < m_step.contactCount; ++i) onCollision.broadcast(m_step.contacts[i]);
}

void SteppingThread::send(std::int64_t computedAt) noexcept
{
	DeviceCommand command;
	command.sequence = ++m_sequence;
	command.basedOn = m_state.sequence;
	command.computedAt = computedAt;
	command.expiresAt = computedAt + m_settings.safety.zeroFrom;
	command.wrench = m_wanted;
	// If a tick took longer than a period, its command may have expired. Any other tick counts as instantaneous, so that a replay of a
	// recorded run gives the same bits.
	const std::int64_t finished = m_time.now();
	const bool slow = finished - m_lastTick >= m_settings.period;
	const std::int64_t now = slow ? finished : std::max(m_lastTick, std::min(m_state.sampledAt, finished));
	const bool jumped = m_time.jumps() != m_seenJumps, stalled = now - m_lastTick >= m_settings.safety.zeroFrom;
	m_seenJumps = m_time.jumps();
	if (jumped) m_limiter.restart();
	const bool wasFaulted = m_limiter.faulted();
	m_sent = m_limiter.limit(command, {m_state.X_WH, m_state.twist, m_state.flags, m_step.contactCount > 0}, now);
	if (!wasFaulted && m_limiter.faulted()) m_latchedCause = FaultCause::NotFinite;
	if (!m_limiter.faulted()) m_latchedCause = FaultCause::None;
	const bool written = m_device.write(m_sent) == DeviceStatus::Ok;
	if (!written)
	{
		if (!m_refuses) m_refusesSince = now;
		increment(m_deviceErrors);
		m_sent.wrench = {};
		m_limiter.takeBack();
		// As with samples: after longer than a glitch the hand has gone on without a force.
		if (now - m_refusesSince > m_settings.safety.fullUntil) m_limiter.restart();
	}
	m_refuses = !written;
	const FaultCause latched = m_latchedCause == FaultCause::None ? FaultCause::Raised : m_latchedCause;
	if (m_limiter.faulted()) report(latched, true);
	else
		report(!written   ? FaultCause::Disconnected
				: jumped  ? FaultCause::ClockJump
				: stalled ? FaultCause::Stalled
						  : FaultCause::None,
			false);
}

void SteppingThread::sendZero(FaultCause cause, std::int64_t at) noexcept
{
	m_wanted = {};
	DeviceCommand command;
	command.sequence = ++m_sequence;
	command.basedOn = m_state.sequence;
	command.computedAt = at;
	command.expiresAt = command.computedAt + m_settings.safety.zeroFrom;
	m_sent = m_limiter.zero(command, command.computedAt);
	if (m_device.write(m_sent) != DeviceStatus::Ok) increment(m_deviceErrors);
	report(cause, m_limiter.faulted());
}

void SteppingThread::report(FaultCause cause, bool latched) noexcept
{
	const FaultCause before = m_cause.exchange(cause, std::memory_order_relaxed);
	if (cause == before || cause == FaultCause::None) return;
	increment(m_faults);
	const Fault fault{cause, m_time.now(), latched};
	try
	{
		onFault.broadcast(fault);
	}
	catch (...)
	{
		m_limiter.raiseFault();
	}
}
}  // namespace devicebridge
