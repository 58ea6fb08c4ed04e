// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

#include "DeviceBridge/Device/DeviceLink.h"

struct _SDL_GameController;

namespace devicebridge
{
struct RumbleSettings
{
	int index = 0;            ///< index among the game controllers of SDL
	double reach = 0.05;      ///< displacement of a stick at its end [m]
	double fullForce = 1;     ///< force that drives the strong motor at its maximum [N]
	double fullTorque = 0.1;  ///< torque that drives the weak motor at its maximum [N m]
};

/// A game controller through SDL2. The left stick is the handle in x and y, and the right stick's vertical axis is z. W has x to the right,
/// y up, z towards the user. Buttons are numbered as in SDL_GameControllerButton. A controller cannot push: the magnitude of the force
/// drives the strong motor, that of the torque the weak one.
class RumbleLink final : public DeviceLink
{
public:
	RumbleLink(const RumbleSettings& settings, std::string uri) : m_settings(settings), m_uri(std::move(uri)) {}
	~RumbleLink() override { disconnect(); }

	ist::Result<DeviceInfo> connect() noexcept override;
	Event exchange(const DeviceCommand& command, DeviceSample& sample) noexcept override;
	void disconnect() noexcept override;
	std::string complaint() const override { return "the game controller was unplugged"; }

private:
	bool rumble(const ist::Wrench& wrench, std::int64_t now) noexcept;
	double axis(int which) const noexcept;

	RumbleSettings m_settings;
	std::string m_uri;
	_SDL_GameController* m_controller = nullptr;
	bool m_initialised = false;
	std::int64_t m_next = 0, m_sentAt = 0, m_lastTime = 0;
	unsigned m_low = 0, m_high = 0;
	ist::Vec3 m_position;
};

/// Why `rumble:` can open no controller; empty if there is one.
std::string rumbleMissing();
}  // namespace devicebridge
