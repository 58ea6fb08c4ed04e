// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Decorators/ClutchedDevice.h"

namespace devicebridge
{
DeviceStatus ClutchedDevice::read(std::int64_t now, DeviceState& state) noexcept
{
	DeviceState own;  // not the last sample, whose flags are those of an open clutch
	const DeviceStatus status = m_inner->read(now, own);
	if (status != DeviceStatus::Ok) return status;
	if (!isRigid(own.X_WH))
	{
		state = own;  // to be judged by the caller; an open clutch must neither hide nor keep it
		return status;
	}
	const bool wasOpen = m_open;
	m_open = (own.buttons & m_buttons) != 0;
	if (!m_hasPose) m_frozen = own.X_WH;
	m_hasPose = true;
	if (wasOpen || m_open)
	{
		m_turn = rotationMatrix(ist::quaternion(transpose(own.X_WH.rotation) * m_frozen.rotation));
		m_shift = m_frozen.translation - own.X_WH.translation;
	}
	state = own;
	state.X_WH = {own.X_WH.rotation * m_turn, own.X_WH.translation + m_shift};
	m_frozen = m_open ? m_frozen : state.X_WH;
	m_moved = m_frozen * inverse(own.X_WH);
	if (!m_open) return status;
	state.X_WH = m_frozen;
	state.twist = {};
	state.flags &= ~static_cast<std::uint32_t>(kForcesEnabled);
	return status;
}

DeviceStatus ClutchedDevice::write(const DeviceCommand& command) noexcept
{
	if (!m_open) return m_inner->write(command);
	DeviceCommand none = command;
	none.wrench = {};
	none.gripForce = 0;
	return m_inner->write(none);
}

bool ClutchedDevice::readHand(HandState& hand) noexcept
{
	if (!m_inner->readHand(hand)) return false;
	moveHand(hand, m_moved);
	return true;
}
}  // namespace devicebridge
