// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "DeviceBridge/Device/DeviceLink.h"

namespace devicebridge
{
/// A device behind a link whose calls may block. A separate thread runs the link and publishes the newest sample, so read() and write()
/// never wait. That thread also replaces a command that expires by zero, even if no further call comes.
///   link lost              -> read() and write() return Disconnected, and complaint() says why
///   no new sample          -> the sample and its sequence repeat, which SampleMonitor reports as a frozen device
///   a call that never ends -> the same; close() abandons the thread after kPatience, and open() is refused until it ends
class ThreadedDevice final : public Device
{
public:
	static constexpr std::int64_t kPatience = 2'000'000'000;          ///< longest wait of close() for the thread [ns]
	static constexpr std::int64_t kOpeningPatience = 10'000'000'000;  ///< wait for the connection, and again for the first sample [ns]

	explicit ThreadedDevice(std::unique_ptr<DeviceLink> link);
	~ThreadedDevice() override;

	/// The properties that the first open() found.
	const DeviceInfo& info() const noexcept override { return m_info; }
	/// Waits until the device is connected and the first sample has come.
	DeviceStatus open() noexcept override;
	void close() noexcept override;
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override;
	DeviceStatus write(const DeviceCommand& command) noexcept override;
	bool readHand(HandState& hand) noexcept override;
	std::string complaint() const override;

private:
	struct Worker;
	bool takeInfo() noexcept;

	std::unique_ptr<DeviceLink> m_link;  // the link while no worker owns it
	std::shared_ptr<Worker> m_worker;    // shared with its thread, which may have to be abandoned
	DeviceInfo m_info;
	bool m_hasInfo = false;
	std::int64_t m_shift = 0, m_lastNow = 0;
	bool m_hasShift = false;
};
}  // namespace devicebridge
