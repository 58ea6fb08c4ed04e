// SPDX-License-Identifier: Zlib
#pragma once

#include <algorithm>
#include <cstdint>

#include "DeviceBridge/Device/Device.h"

namespace devicebridge
{
/// Share of a command that still counts: all of it up to the age `fullUntil`, none from `zeroFrom` on, linear between;
/// none of an expired command, nor of one from the future.
struct AgeFade
{
	std::int64_t fullUntil = 5'000'000, zeroFrom = 20'000'000;  ///< [ns], fullUntil < zeroFrom

	double factor(const DeviceCommand& command, std::int64_t now) const noexcept
	{
		const std::int64_t age = now - command.computedAt;
		if (age < 0 || age >= zeroFrom || now >= command.expiresAt) return 0;
		if (age <= fullUntil) return 1;
		return static_cast<double>(zeroFrom - age) / static_cast<double>(zeroFrom - fullUntil);
	}
};
}  // namespace devicebridge
