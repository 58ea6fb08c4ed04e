// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Decorators/DeviceDecorator.h"

namespace devicebridge
{
/// While a button is held, the handle moves alone: the reported pose stays, and twist and force are zero. Afterwards the pose continues
/// from where it stayed. Its position is shifted in W, and its orientation is rotated in the handle's own axes. So the reported handle
/// moves and turns about the axes of W as the true one does. Twist and wrench mean the same for both.
class ClutchedDevice final : public DeviceDecorator
{
public:
	/// `buttons` are bits of DeviceState::buttons, any of which opens the clutch. While it is open, the flags lack kForcesEnabled, so that
	/// the force returns along the ramp.
	ClutchedDevice(std::unique_ptr<Device> inner, std::uint32_t buttons) : DeviceDecorator(std::move(inner)), m_buttons(buttons) {}

	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override;
	DeviceStatus write(const DeviceCommand& command) noexcept override;
	/// The hand moves with the handle: the fingers continue to move while the handle stays.
	bool readHand(HandState& hand) noexcept override;

private:
	std::uint32_t m_buttons;
	ist::Mat3 m_turn;   ///< rotation from the axes of the reported handle to those of the true one
	ist::Vec3 m_shift;  ///< reported minus true position [m]
	ist::Pose m_frozen;
	ist::Pose m_moved;  ///< motion from the true to the reported handle
	bool m_open = false, m_hasPose = false;
};
}  // namespace devicebridge
