// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Decorators/DeviceDecorator.h"

namespace devicebridge
{
/// Where the base D of a device stands in the world W, and how many metres of W one metre of its handle is:
///   x_W = R_WD (scale x_D) + p_WD.
/// Power is kept: a force shrinks as the way grows (F_D = scale F_W), a torque does not change. The limits of info() are those
/// felt in W: forces / scale, linear stiffness and damping / scale^2, lengths * scale.
class MountedDevice final : public DeviceDecorator
{
public:
	/// A scale that is not positive and finite counts as one, a pose that is not rigid as the identity.
	MountedDevice(std::unique_ptr<Device> inner, const ist::Pose& X_WD, double scale = 1);

	const DeviceInfo& info() const noexcept override { return m_info; }
	DeviceStatus open() noexcept override;
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override;
	DeviceStatus write(const DeviceCommand& command) noexcept override;
	bool readHand(HandState& hand) noexcept override;

private:
	void scaleInfo();

	DeviceInfo m_info;
	ist::Pose m_X_WD;
	double m_scale;
	bool m_wasOpen = false;
};
}  // namespace devicebridge
