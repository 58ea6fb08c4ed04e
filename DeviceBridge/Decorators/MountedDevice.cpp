// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Decorators/MountedDevice.h"

#include <cmath>
#include <new>

namespace devicebridge
{
MountedDevice::MountedDevice(std::unique_ptr<Device> inner, const ist::Pose& X_WD, double scale)
	: DeviceDecorator(std::move(inner)),
	  m_X_WD(isRigid(X_WD) ? X_WD : ist::Pose()),
	  m_scale(std::isfinite(scale) && scale > 0 ? scale : 1)
{
	scaleInfo();
}

void MountedDevice::scaleInfo()
{
	m_info = m_inner->info();
	scaleLimits(m_info, m_scale);
}

// Some drivers know their limits only after open(). The result of the first time stays, because other threads may read it.
DeviceStatus MountedDevice::open() noexcept
{
	const DeviceStatus status = m_inner->open();
	if (status != DeviceStatus::Ok || m_wasOpen) return status;
	try
	{
		scaleInfo();
		m_wasOpen = true;
	}
	catch (const std::bad_alloc&)
	{
		m_inner->close();
		return DeviceStatus::Refused;
	}
	return status;
}

DeviceStatus MountedDevice::read(std::int64_t now, DeviceState& state) noexcept
{
	DeviceState own = state;
	const DeviceStatus status = m_inner->read(now, own);
	if (status != DeviceStatus::Ok) return status;
	state = own;
	state.X_WH = m_X_WD * ist::Pose{own.X_WH.rotation, m_scale * own.X_WH.translation};
	state.twist = {m_X_WD.rotation * (m_scale * own.twist.linear), m_X_WD.rotation * own.twist.angular};
	return status;
}

DeviceStatus MountedDevice::write(const DeviceCommand& command) noexcept
{
	DeviceCommand own = command;
	const ist::Mat3 R_DW = transpose(m_X_WD.rotation);
	own.wrench = {R_DW * (m_scale * command.wrench.force), R_DW * command.wrench.torque};
	return m_inner->write(own);
}

bool MountedDevice::readHand(HandState& hand) noexcept
{
	if (!m_inner->readHand(hand)) return false;
	moveHand(hand, m_X_WD, m_scale);
	return true;
}
}  // namespace devicebridge
