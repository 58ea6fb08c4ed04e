// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdio>
#include <memory>
#include <string>

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Plugins/devicebridge_plugin.h"
#include "DeviceBridge/Timing/Clock.h"

namespace devicebridge::plugin
{
/// Keeps a minimum time between two samples, so that a vendor's call that does not block cannot use the whole processor.
class Pace
{
public:
	explicit Pace(std::int64_t period) : m_period(period) {}
	void wait() noexcept
	{
		const std::int64_t now = m_clock.now();
		m_next = m_next + m_period < now ? now : m_next + m_period;
		m_clock.sleepUntil(m_next);
	}

private:
	RealClock m_clock;
	std::int64_t m_period, m_next = 0;
};

inline void say(char* why, std::size_t room, const std::string& text) { std::snprintf(why, room, "%s", text.c_str()); }

template <std::size_t N> void setText(char (&field)[N], const std::string& text) { say(field, N, text); }

/// `assumed` has the bits DEVICEBRIDGE_ASSUMED_... of limits that were filled in because the device does not report them. `profile` is the
/// profile for limits that are zero. An older host knows neither, so limits of zero stay unknown to it.
inline void setAssumed(devicebridge_info& info, uint32_t assumed, const std::string& profile = {})
{
	if (info.size < sizeof info) return;
	info.assumed = assumed;
	setText(info.profile, profile);
}

/// Results of devicebridge_plugin::exchange.
enum class News
{
	Lost = -1,
	Nothing = 0,
	Sample = 1
};

/// The C table of a device class with
///   static constexpr const char *kName, *kDescription;
///   static std::string missing();
///   static ist::Result<std::unique_ptr<T>> open(const std::string& address, devicebridge_info& info);
///   News exchange(const devicebridge_command&, devicebridge_state&, std::string& why);
/// and a destructor that leaves the device with zero force.
template <class T> const devicebridge_plugin* tableOf()
{
	static const devicebridge_plugin table = {sizeof table, DEVICEBRIDGE_PLUGIN_VERSION, T::kName, T::kDescription,
		[](char* why, std::size_t room) {
			const std::string missing = T::missing();
			say(why, room, missing);
			return missing.empty() ? 0 : 1;
		},
		[](const char* address, devicebridge_info* info, char* why, std::size_t room) -> void* {
			auto device = T::open(address, *info);
			if (device) return std::move(device).value().release();
			say(why, room, device.error().message);
			return nullptr;
		},
		[](void* device, const devicebridge_command* command, devicebridge_state* state, char* why, std::size_t room) {
			std::string reason;
			const News news = static_cast<T*>(device)->exchange(*command, *state, reason);
			if (news == News::Lost) say(why, room, reason);
			return static_cast<int>(news);
		},
		[](void* device) { delete static_cast<T*>(device); }};
	return &table;
}
}  // namespace devicebridge::plugin
