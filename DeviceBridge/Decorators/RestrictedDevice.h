// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Decorators/DeviceDecorator.h"

namespace devicebridge
{
/// A device restricted to some of its degrees of freedom, so that the effect of the others can be compared.
///   not actuated: force, torque or grip force are not sent, and info() reports that the device has none;
///   rotation not sensed: the handle keeps the orientation of the world and has no angular velocity;
///   translation not sensed: the handle stays at the origin.
/// Translation and rotation are each kept or dropped as a whole.
class RestrictedDevice final : public DeviceDecorator
{
public:
	/// `sensed` and `actuated` are the bits of DegreeOfFreedom that may remain.
	RestrictedDevice(std::unique_ptr<Device> inner, unsigned sensed, unsigned actuated);

	const DeviceInfo& info() const noexcept override { return m_info; }
	DeviceStatus open() noexcept override;
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override;
	DeviceStatus write(const DeviceCommand& command) noexcept override;

private:
	void restrictInfo();

	unsigned m_sensed, m_actuated;
	DeviceInfo m_info;
	bool m_wasOpen = false;
};
}  // namespace devicebridge
