// SPDX-License-Identifier: Zlib
#include "DeviceBridge/SteppingThread.h"

#include <algorithm>
#include <cmath>
#include <system_error>

#if defined(__linux__)
#include <pthread.h>
#include <sched.h>
#endif

namespace devicebridge
{
namespace
{
void increment(std::atomic<std::uint64_t>& counter) { counter.fetch_add(1, std::memory_order_relaxed); }
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
	  m_clock(clock),
	  m_settings(settings),
	  m_limiter(device.info(), settings.safety),
	  m_scheduling("on the caller's thread, as that is scheduled")
{
	m_settings.period = std::max<std::int64_t>(1, settings.period);
}

SteppingThread::~SteppingThread() { stop(); }

bool SteppingThread::run(std::int64_t ticks) noexcept
{
	if (running()) return false;
	for (std::int64_t i = 0; i < ticks; ++i)
	{
		waitForTick();
		tick();
	}
	return true;
}

bool SteppingThread::start()
{
	if (running()) return false;
	if (m_thread.joinable()) m_thread.join();
	m_stopping = false;
	m_scheduled = false;
	m_running = true;
	try
	{
		m_thread = std::thread([this] { loop(); });
	}
	catch (const std::system_error&)
	{
		m_running = false;
	}
	return m_running;
}

void SteppingThread::stop() noexcept
{
	m_stopping = true;
	if (m_thread.joinable()) m_thread.join();
}

void SteppingThread::loop() noexcept
{
	askForRealTime();
	while (!m_stopping.load(std::memory_order_acquire))
	{
		waitForTick();
		tick();
	}
	m_limiter.reset();
	m_wanted = {};
	const std::int64_t now = m_clock.now();
	send(now, now);
	m_running.store(false, std::memory_order_release);
}

void SteppingThread::askForRealTime() noexcept
{
	m_scheduling = "normal priority: real time was not asked for";
	if (!m_settings.realTime) return;
#if defined(__linux__)
	sched_param parameters{};
	parameters.sched_priority = m_settings.priority;
	m_scheduling = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0
					   ? "real time (SCHED_FIFO)"
					   : "normal priority: SCHED_FIFO was refused; it needs CAP_SYS_NICE or an rtprio limit";
#else
	m_scheduling = "normal priority: real time is not supported on this platform";
#endif
}

void SteppingThread::waitForTick() noexcept
{
	if (!m_scheduled)
	{
		m_deadline = m_lastTick = m_clock.now();
		m_scheduled = true;
	}
	m_deadline += m_settings.period;
	m_clock.sleepUntil(m_deadline);
	const std::int64_t now = m_clock.now();
	m_periods.add(now - m_lastTick);
	m_lastTick = now;
	if (now - m_deadline <= m_settings.period) return;
	// Missed ticks are dropped: catching up would be a burst of force updates without time between them.
	increment(m_overruns);
	m_deadline = now;
}

void SteppingThread::tick() noexcept
{
	const std::int64_t now = m_lastTick;
	const bool fresh = readDevice(now);
	m_wanted = {};
	std::int64_t computedAt = now;
	if (m_hasState)
	{
		if (fresh) onTransform.broadcast(m_state);
		advanceWorld();
	}
	if (fresh)
	{
		m_wanted = m_law->handWrench(m_state, m_step);
		computedAt = m_law->computedAt(m_state);
		onHapticTick.broadcast(m_state, m_wanted);
	}
	send(computedAt, now);
	increment(m_ticks);
	m_costs.add(m_clock.now() - now);
}

bool SteppingThread::readDevice(std::int64_t now) noexcept
{
	DeviceState state = m_state;
	DeviceStatus status = m_device.read(now, state);
	if (status == DeviceStatus::Ok && !(isRigid(state.X_WH) && isFinite(state.twist)))
	{
		status = DeviceStatus::InvalidState;
		m_limiter.raiseFault();
	}
	if (status != DeviceStatus::Ok)
	{
		increment(m_deviceErrors);
		return false;
	}
	m_state = state;
	m_hasState = true;
	return true;
}

// The nominal period, not the measured one: a late tick must not make the world take a longer, less stable step.
void SteppingThread::advanceWorld() noexcept
{
	m_step.contactCount = 0;
	m_step.overlapVolume = 0;
	m_step.pairs = 0;
	m_source.advance(1e-9 * static_cast<double>(m_settings.period), m_state, m_step);
	m_step.contactCount = std::clamp(m_step.contactCount, 0, kMaxToolContacts);
	for (int i = 0; i < m_step.contactCount; ++i) onCollision.broadcast(m_step.contacts[i]);
}

void SteppingThread::send(std::int64_t computedAt, std::int64_t now) noexcept
{
	DeviceCommand command;
	command.sequence = ++m_sequence;
	command.basedOn = m_state.sequence;
	command.computedAt = computedAt;
	command.expiresAt = computedAt + m_settings.safety.zeroFrom;
	command.wrench = m_wanted;
	m_sent = m_limiter.limit(command, now);
	if (m_device.write(m_sent) != DeviceStatus::Ok) increment(m_deviceErrors);
}
}  // namespace devicebridge
