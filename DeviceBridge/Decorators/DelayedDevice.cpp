// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Decorators/DelayedDevice.h"

#include <algorithm>

namespace devicebridge
{
DelayedDevice::DelayedDevice(std::unique_ptr<Device> inner, int stateTicks, int commandTicks)
	: DeviceDecorator(std::move(inner)),
	  m_states(static_cast<std::size_t>(std::max(0, stateTicks)) + 1),
	  m_commands(static_cast<std::size_t>(std::max(0, commandTicks)) + 1)
{}

DeviceStatus DelayedDevice::open() noexcept
{
	m_reads = m_writes = 0;
	return DeviceDecorator::open();
}

DeviceStatus DelayedDevice::read(std::int64_t now, DeviceState& state) noexcept
{
	Sample& newest = m_states[m_reads % m_states.size()];
	newest.status = m_inner->read(now, newest.state);
	newest.hasHand = m_inner->readHand(newest.hand);
	if (++m_reads < m_states.size()) return DeviceStatus::Disconnected;
	const Sample& oldest = m_states[m_reads % m_states.size()];
	if (oldest.status == DeviceStatus::Ok) state = oldest.state;
	return oldest.status;
}

bool DelayedDevice::readHand(HandState& hand) noexcept
{
	const Sample& oldest = m_states[m_reads % m_states.size()];
	if (m_reads < m_states.size() || !oldest.hasHand) return false;
	hand = oldest.hand;
	return true;
}

DeviceStatus DelayedDevice::write(const DeviceCommand& command) noexcept
{
	m_commands[m_writes % m_commands.size()] = command;
	if (++m_writes < m_commands.size()) return DeviceStatus::Ok;
	return m_inner->write(m_commands[m_writes % m_commands.size()]);
}
}  // namespace devicebridge
