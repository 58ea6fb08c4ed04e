// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Decorators/ReconnectingDevice.h"

#include <algorithm>
#include <chrono>
#include <system_error>

namespace devicebridge
{
namespace
{
// A tick wakes no thread, because waking may block. So the reconnecting thread polls for a loss.
constexpr std::int64_t kLookEvery = 5'000'000;  // [ns]
}  // namespace

std::int64_t reconnectDelay(const ReconnectSettings& settings, int attempt) noexcept
{
	std::int64_t delay = std::max<std::int64_t>(1, settings.firstDelay);
	for (int i = 0; i < attempt && delay < settings.longestDelay; ++i) delay *= 2;
	return std::min(delay, std::max<std::int64_t>(1, settings.longestDelay));
}

ReconnectingDevice::ReconnectingDevice(std::unique_ptr<Device> inner, const ReconnectSettings& settings)
	: DeviceDecorator(std::move(inner)),
	  m_settings(settings)
{}

ReconnectingDevice::~ReconnectingDevice() { endThread(); }

DeviceStatus ReconnectingDevice::open() noexcept
{
	endThread();
	m_owner = Owner::User;
	{
		const std::lock_guard<std::mutex> opening(m_opening);
		const DeviceStatus status = m_inner->open();
		if (status != DeviceStatus::Ok) return status;
	}
	try
	{
		m_ending = false;
		m_thread = std::thread([this] { reconnectLoop(); });
	}
	catch (const std::system_error&)
	{
		const std::lock_guard<std::mutex> opening(m_opening);
		m_inner->close();
		return DeviceStatus::Refused;
	}
	return DeviceStatus::Ok;
}

void ReconnectingDevice::close() noexcept
{
	endThread();
	m_owner = Owner::User;
	const std::lock_guard<std::mutex> opening(m_opening);
	m_inner->close();
}

DeviceStatus ReconnectingDevice::reopen()
{
	const std::lock_guard<std::mutex> opening(m_opening);
	std::string said = m_inner->complaint();
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		m_complaint = std::move(said);
	}
	m_inner->close();
	const DeviceStatus status = m_inner->open();
	const std::lock_guard<std::mutex> lock(m_mutex);
	if (status == DeviceStatus::Ok) m_complaint.clear();
	return status;
}

void ReconnectingDevice::endThread() noexcept
{
	if (!m_thread.joinable()) return;
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		m_ending = true;
	}
	m_wake.notify_all();
	m_thread.join();
}

DeviceStatus ReconnectingDevice::judge(DeviceStatus status) noexcept
{
	const bool lost = status == DeviceStatus::Disconnected || status == DeviceStatus::NotOpen;
	if (!lost || !m_thread.joinable()) return status;
	m_owner.store(Owner::Reconnector, std::memory_order_release);
	return DeviceStatus::Disconnected;
}

DeviceStatus ReconnectingDevice::read(std::int64_t now, DeviceState& state) noexcept
{
	if (m_owner.load(std::memory_order_acquire) != Owner::User) return DeviceStatus::Disconnected;
	return judge(m_inner->read(now, state));
}

DeviceStatus ReconnectingDevice::write(const DeviceCommand& command) noexcept
{
	if (m_owner.load(std::memory_order_acquire) != Owner::User) return DeviceStatus::Disconnected;
	return judge(m_inner->write(command));
}

bool ReconnectingDevice::readHand(HandState& hand) noexcept
{
	return m_owner.load(std::memory_order_acquire) == Owner::User && m_inner->readHand(hand);
}

std::string ReconnectingDevice::complaint() const
{
	const std::unique_lock<std::mutex> opening(m_opening, std::try_to_lock);
	if (opening) return m_inner->complaint();  // no other thread uses the device, and it is not being opened
	const std::lock_guard<std::mutex> lock(m_mutex);
	return m_complaint;
}

/// Returns false when the thread must end.
bool ReconnectingDevice::sleepFor(std::int64_t nanoseconds)
{
	std::unique_lock<std::mutex> lock(m_mutex);
	return !m_wake.wait_for(lock, std::chrono::nanoseconds(nanoseconds), [this] { return m_ending; });
}

void ReconnectingDevice::reconnectLoop()
{
	int attempt = 0;
	while (sleepFor(m_owner.load(std::memory_order_acquire) == Owner::User ? kLookEvery : reconnectDelay(m_settings, attempt)))
	{
		if (m_owner.load(std::memory_order_acquire) == Owner::User)
		{
			attempt = 0;
			continue;
		}
		++attempt;
		if (reopen() != DeviceStatus::Ok) continue;
		m_reconnections.fetch_add(1, std::memory_order_relaxed);
		m_owner.store(Owner::User, std::memory_order_release);
	}
}
}  // namespace devicebridge
