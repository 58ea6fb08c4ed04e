// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Decorators/LimitedDevice.h"

#include <utility>

namespace devicebridge
{
LimitedDevice::LimitedDevice(std::unique_ptr<Device> inner, const SafetySettings& settings)
	: DeviceDecorator(std::move(inner)),
	  m_limiter(m_inner->info(), settings),
	  m_zeroFrom(settings.zeroFrom)
{}

DeviceStatus LimitedDevice::open() noexcept
{
	m_limiter.restart();
	m_hasSample = false;
	m_sent = {};
	return m_inner->open();
}

void LimitedDevice::close() noexcept
{
	m_hasSample = false;
	m_sent = {};
	m_inner->close();
}

DeviceStatus LimitedDevice::read(std::int64_t now, DeviceState& state) noexcept
{
	const DeviceStatus status = m_inner->read(now, state);
	m_now = now;
	m_hasSample = status == DeviceStatus::Ok;
	if (!m_hasSample) return status;
	m_hand.X_WH = state.X_WH;
	m_hand.twist = state.twist;
	m_hand.flags = state.flags;
	return status;
}

DeviceStatus LimitedDevice::write(const DeviceCommand& command) noexcept
{
	const ist::Wrench& wanted = command.wrench;
	m_hand.inContact = !(wanted.force == ist::Vec3{} && wanted.torque == ist::Vec3{});
	const bool sinceRead = command.computedAt > m_now && command.computedAt - m_now < m_zeroFrom;
	const std::int64_t now = sinceRead ? command.computedAt : m_now;
	const DeviceCommand limited = m_hasSample ? m_limiter.limit(command, m_hand, now) : m_limiter.zero(command, now);
	const DeviceStatus status = m_inner->write(limited);
	if (status != DeviceStatus::Ok) m_limiter.takeBack();
	m_sent = status == DeviceStatus::Ok ? limited.wrench : ist::Wrench();
	return status;
}
}  // namespace devicebridge
