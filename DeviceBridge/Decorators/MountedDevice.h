// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Decorators/DeviceDecorator.h"

namespace devicebridge
{
/// A device whose base D stands at a pose in the world W. One metre of its handle is `scale` metres in W:
///   x_W = R_WD (scale x_D) + p_WD.
/// Power is preserved: a force decreases as the displacement grows (F_D = scale F_W), and a torque does not change. The limits of info()
/// are those felt in W: forces / scale, linear stiffness and damping / scale^2, lengths * scale.
class MountedDevice final : public DeviceDecorator
{
public:
	/// A scale that is not positive and finite is replaced by one, and a pose that is not rigid by the identity.
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
