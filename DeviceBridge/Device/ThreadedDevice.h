// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "DeviceBridge/Device/DeviceLink.h"

namespace devicebridge
{
/// A device behind a link whose calls may block. The link has a thread of its own, which publishes the newest sample; read() and
/// write() never wait. A command that expires is replaced by zero on that thread, whether or not anybody calls.
///   link lost              -> read() and write() answer Disconnected, complaint() says why
///   no new sample          -> the sample and its sequence repeat, which SampleMonitor takes for a frozen device
///   a call that never ends -> the same; close() leaves the thread behind after kPatience, and open() is refused until it ends
class ThreadedDevice final : public Device
{
public:
	static constexpr std::int64_t kPatience = 2'000'000'000;          ///< [ns]
	static constexpr std::int64_t kOpeningPatience = 10'000'000'000;  ///< until connected, and again until the first sample [ns]

	explicit ThreadedDevice(std::unique_ptr<DeviceLink> link);
	~ThreadedDevice() override;

	/// What the first open() found.
	const DeviceInfo& info() const noexcept override { return m_info; }
	/// Waits until the device is there and the first sample has come.
	DeviceStatus open() noexcept override;
	void close() noexcept override;
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override;
	DeviceStatus write(const DeviceCommand& command) noexcept override;
	bool readHand(HandState& hand) noexcept override;
	std::string complaint() const override;

private:
	struct Worker;
	bool takeInfo() noexcept;

	std::unique_ptr<DeviceLink> m_link;  // while no worker has it
	std::shared_ptr<Worker> m_worker;    // shared with its thread, which may have to be left behind
	DeviceInfo m_info;
	bool m_hasInfo = false;
	std::int64_t m_shift = 0, m_lastNow = 0;
	bool m_hasShift = false;
};
}  // namespace devicebridge
