// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Decorators/DeviceDecorator.h"

namespace devicebridge
{
/// While a button is held the handle moves alone: the reported pose stays, the twist and the force are zero. Afterwards the
/// pose goes on from where it stayed: shifted in W, and turned in the handle's own axes, so that it moves and turns about the axes of W
/// as the handle does, and twist and wrench mean the same on both sides.
class ClutchedDevice final : public DeviceDecorator
{
public:
	/// Bits of DeviceState::buttons, any of which opens the clutch. Flags lose kForcesEnabled while it is open, so that the
	/// force comes back along the ramp.
	ClutchedDevice(std::unique_ptr<Device> inner, std::uint32_t buttons) : DeviceDecorator(std::move(inner)), m_buttons(buttons) {}

	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override;
	DeviceStatus write(const DeviceCommand& command) noexcept override;
	/// With the handle: the fingers go on moving while it stays.
	bool readHand(HandState& hand) noexcept override;

private:
	std::uint32_t m_buttons;
	ist::Mat3 m_turn;   ///< from the axes of the reported handle to those of the true one
	ist::Vec3 m_shift;  ///< reported minus true position [m]
	ist::Pose m_frozen;
	ist::Pose m_moved;  ///< from the true to the reported handle
	bool m_open = false, m_hasPose = false;
};
}  // namespace devicebridge
