// SPDX-License-Identifier: Zlib
#pragma once

#include <memory>
#include <utility>

#include "DeviceBridge/Device/Device.h"

namespace devicebridge
{
/// A device that changes what another device reports or receives. It owns the other device.
class DeviceDecorator : public Device
{
public:
	explicit DeviceDecorator(std::unique_ptr<Device> inner) : m_inner(std::move(inner)) {}

	const DeviceInfo& info() const noexcept override { return m_inner->info(); }
	DeviceStatus open() noexcept override { return m_inner->open(); }
	void close() noexcept override { m_inner->close(); }
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override { return m_inner->read(now, state); }
	DeviceStatus write(const DeviceCommand& command) noexcept override { return m_inner->write(command); }
	bool readHand(HandState& hand) noexcept override { return m_inner->readHand(hand); }
	std::string complaint() const override { return m_inner->complaint(); }

	Device& inner() { return *m_inner; }

protected:
	std::unique_ptr<Device> m_inner;
};
}  // namespace devicebridge
