// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Decorators/RestrictedDevice.h"

#include <new>

namespace devicebridge
{
RestrictedDevice::RestrictedDevice(std::unique_ptr<Device> inner, unsigned sensed, unsigned actuated)
	: DeviceDecorator(std::move(inner)),
	  m_sensed(sensed),
	  m_actuated(actuated)
{
	restrictInfo();
}

void RestrictedDevice::restrictInfo()
{
	m_info = m_inner->info();
	m_info.sensed &= m_sensed;
	m_info.actuated &= m_actuated;
	if (!(m_info.actuated & kTranslation))
		m_info.peakForce = m_info.continuousForce = m_info.maxStiffness = m_info.maxDamping = m_info.damping = 0;
	if (m_info.actuated & kRotation) return;
	m_info.peakTorque = m_info.continuousTorque = m_info.maxAngularStiffness = m_info.maxAngularDamping = m_info.angularDamping = 0;
}

// Some drivers know their limits only after open(). The result of the first time stays, because other threads may read it.
DeviceStatus RestrictedDevice::open() noexcept
{
	const DeviceStatus status = m_inner->open();
	if (status != DeviceStatus::Ok || m_wasOpen) return status;
	try
	{
		restrictInfo();
		m_wasOpen = true;
	}
	catch (const std::bad_alloc&)
	{
		m_inner->close();
		return DeviceStatus::Refused;
	}
	return status;
}

DeviceStatus RestrictedDevice::read(std::int64_t now, DeviceState& state) noexcept
{
	DeviceState own = state;
	const DeviceStatus status = m_inner->read(now, own);
	if (status != DeviceStatus::Ok) return status;
	state = own;
	if (!(m_sensed & kRotation)) state.X_WH.rotation = {}, state.twist.angular = {};
	if (!(m_sensed & kTranslation)) state.X_WH.translation = state.twist.linear = {};
	if (!(m_sensed & kGrip)) state.gripAngle = state.gripVelocity = 0;
	return status;
}

DeviceStatus RestrictedDevice::write(const DeviceCommand& command) noexcept
{
	DeviceCommand own = command;
	if (!(m_actuated & kTranslation)) own.wrench.force = {};
	if (!(m_actuated & kRotation)) own.wrench.torque = {};
	if (!(m_actuated & kGrip)) own.gripForce = 0;
	return m_inner->write(own);
}
}  // namespace devicebridge
