// SPDX-License-Identifier: Zlib
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include "DeviceBridge/Decorators/DeviceDecorator.h"

namespace devicebridge
{
struct ReconnectSettings
{
	std::int64_t firstDelay = 50'000'000;       ///< time between the loss and the first attempt [ns]; doubles with each failure
	std::int64_t longestDelay = 2'000'000'000;  ///< longest time between attempts [ns]
};

/// Waiting time before attempt `attempt` = 0, 1, ... [ns].
std::int64_t reconnectDelay(const ReconnectSettings& settings, int attempt) noexcept;

/// Closes and reopens a lost device on a separate thread, because open() of a driver may take seconds. Until then read() and write() return
/// Disconnected at once. Exactly one of the two threads owns the device at any time.
class ReconnectingDevice final : public DeviceDecorator
{
public:
	explicit ReconnectingDevice(std::unique_ptr<Device> inner, const ReconnectSettings& settings = {});
	/// Waits for an attempt in progress.
	~ReconnectingDevice() override;

	DeviceStatus open() noexcept override;
	/// Waits for an attempt in progress.
	void close() noexcept override;
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override;
	DeviceStatus write(const DeviceCommand& command) noexcept override;
	bool readHand(HandState& hand) noexcept override;
	/// For any thread. While the device is being opened, it is the complaint from before.
	std::string complaint() const override;
	/// For any thread.
	std::uint64_t reconnections() const noexcept { return m_reconnections.load(std::memory_order_relaxed); }

private:
	enum class Owner
	{
		User,
		Reconnector
	};
	DeviceStatus judge(DeviceStatus status) noexcept;
	void reconnectLoop();
	DeviceStatus reopen();
	bool sleepFor(std::int64_t nanoseconds);
	void endThread() noexcept;

	ReconnectSettings m_settings;
	std::atomic<Owner> m_owner{Owner::User};
	std::atomic<std::uint64_t> m_reconnections{0};
	mutable std::mutex m_opening;  // held while the device is closed and opened, and while its complaint is read
	mutable std::mutex m_mutex;    // guards the members below; read() and write() never lock either mutex
	std::condition_variable m_wake;
	bool m_ending = false;
	std::string m_complaint;
	std::thread m_thread;
};
}  // namespace devicebridge
