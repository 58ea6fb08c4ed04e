// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

#include "DeviceBridge/Device/DeviceLink.h"

struct _SDL_GameController;

namespace devicebridge
{
struct RumbleSettings
{
	int index = 0;            ///< among the game controllers of SDL
	double reach = 0.05;      ///< of a stick at its end [m]
	double fullForce = 1;     ///< that drives the strong motor at its most [N]
	double fullTorque = 0.1;  ///< that drives the weak motor at its most [N m]
};

/// A game controller through SDL2. The left stick is the handle in x and y, the right one's up and down is z (W = x to the right, y up, z
/// towards the user); buttons as SDL_GameControllerButton numbers them. It cannot push: the size of the force drives the strong motor,
/// that of the torque the weak one.
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

/// Why no controller can be had by `rumble:`; empty when there is one.
std::string rumbleMissing();
}  // namespace devicebridge
