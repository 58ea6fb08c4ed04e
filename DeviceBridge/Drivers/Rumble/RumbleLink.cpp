// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Rumble/RumbleLink.h"

#include <SDL2/SDL.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "DeviceBridge/Timing/Clock.h"

namespace devicebridge
{
namespace
{
constexpr std::int64_t kPeriod = 4'000'000, kRepeat = 50'000'000;  // [ns]
constexpr unsigned kLasts = 100;                                   // time after which the motors stop by themselves [ms]

/// Guards SDL, which counts its users without a lock.
std::mutex& sdlMutex()
{
	static std::mutex mutex;
	return mutex;
}

/// Returns false if it fails; SDL_GetError() then says why.
bool startSdl()
{
	SDL_SetMainReady();
	SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
	SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
	return SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER) == 0;
}

/// Index in SDL of the game controller number `wanted`; negative if there are fewer. `count` receives the number of controllers.
int controllerAt(int wanted, int& count)
{
	count = 0;
	int found = -1;
	for (int i = 0; i < SDL_NumJoysticks(); ++i)
	{
		if (!SDL_IsGameController(i)) continue;
		if (count++ == wanted) found = i;
	}
	return found;
}

unsigned motor(double size, double full) { return static_cast<unsigned>(std::lround(65535 * std::clamp(size / full, 0.0, 1.0))); }
}  // namespace

std::string rumbleMissing()
{
	const std::lock_guard<std::mutex> lock(sdlMutex());
	if (!startSdl()) return std::string("SDL does not start: ") + SDL_GetError();
	int count = 0;
	controllerAt(0, count);
	SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
	return count ? std::string() : "SDL finds no game controller; plug one in, and see that you may read /dev/input";
}

ist::Result<DeviceInfo> RumbleLink::connect() noexcept
{
	const std::lock_guard<std::mutex> lock(sdlMutex());
	if (!startSdl()) return ist::Error{std::string("SDL does not start: ") + SDL_GetError(), false};
	m_initialised = true;
	int count = 0;
	const int index = controllerAt(m_settings.index, count);
	if (index < 0)
		return ist::Error{
			"SDL finds " + std::to_string(count) + " game controllers, there is no rumble:" + std::to_string(m_settings.index), false};
	m_controller = SDL_GameControllerOpen(index);
	if (!m_controller) return ist::Error{std::string("SDL cannot open the game controller: ") + SDL_GetError(), false};
	m_low = m_high = 0;
	m_lastTime = 0;
	DeviceInfo info;
	info.uri = m_uri;
	const char* const name = SDL_GameControllerName(m_controller);
	info.model = name ? name : "game controller";
	info.sensed = kTranslation;
	info.nominalRate = 1e9 / kPeriod;
	info.workspaceRadius = m_settings.reach;
	info.source = "a convention: the force and torque that drive the motors at their most";
	if (!SDL_GameControllerHasRumble(m_controller)) return info;
	info.actuated = kTranslation | kRotation;
	info.peakForce = info.continuousForce = m_settings.fullForce;
	info.peakTorque = info.continuousTorque = m_settings.fullTorque;
	return info;
}

double RumbleLink::axis(int which) const noexcept
{
	return std::max(-1.0, SDL_GameControllerGetAxis(m_controller, static_cast<SDL_GameControllerAxis>(which)) / 32767.0);
}

/// Drives the motors. They continue for a while, so that not every exchange must send a report over a slow radio.
bool RumbleLink::rumble(const ist::Wrench& wrench, std::int64_t now) noexcept
{
	const unsigned low = motor(norm(wrench.force), m_settings.fullForce), high = motor(norm(wrench.torque), m_settings.fullTorque);
	const bool on = low || high;
	if (low == m_low && high == m_high && (!on || now - m_sentAt < kRepeat)) return true;
	m_low = low, m_high = high;
	m_sentAt = now;
	return SDL_GameControllerRumble(m_controller, static_cast<Uint16>(low), static_cast<Uint16>(high), on ? kLasts : 0) == 0;
}

DeviceLink::Event RumbleLink::exchange(const DeviceCommand& command, DeviceSample& sample) noexcept
{
	RealClock clock;
	m_next = std::max(m_next + kPeriod, clock.now());
	clock.sleepUntil(m_next);
	SDL_GameControllerUpdate();
	if (!SDL_GameControllerGetAttached(m_controller)) return Event::Lost;
	const std::int64_t now = clock.now();
	rumble(command.wrench, now);
	// In SDL, down is positive.
	const ist::Vec3 position = m_settings.reach *
		ist::Vec3{axis(SDL_CONTROLLER_AXIS_LEFTX), -axis(SDL_CONTROLLER_AXIS_LEFTY), axis(SDL_CONTROLLER_AXIS_RIGHTY)};
	const double dt = 1e-9 * static_cast<double>(now - m_lastTime);
	if (m_lastTime != 0 && dt > 0) sample.state.twist.linear = (position - m_position) / dt;
	m_position = position;
	m_lastTime = now;
	sample.state.X_WH.translation = position;
	sample.state.velocityEstimated = true;
	sample.state.sampledAt = now;
	for (int i = 0; i < SDL_CONTROLLER_BUTTON_MAX && i < 32; ++i)
		if (SDL_GameControllerGetButton(m_controller, static_cast<SDL_GameControllerButton>(i))) sample.state.buttons |= 1U << i;
	return Event::Sample;
}

void RumbleLink::disconnect() noexcept
{
	const std::lock_guard<std::mutex> lock(sdlMutex());
	if (m_controller)
	{
		SDL_GameControllerRumble(m_controller, 0, 0, 0);
		SDL_GameControllerClose(m_controller);
	}
	m_controller = nullptr;
	if (m_initialised) SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
	m_initialised = false;
}
}  // namespace devicebridge
