// SPDX-License-Identifier: Zlib
#pragma once

#include <algorithm>
#include <cstdint>

#include "DeviceBridge/Device/Device.h"

namespace devicebridge
{
/// Weight of a command by its age: one up to `fullUntil`, zero from `zeroFrom`, linear between. It is zero for a command that has expired
/// or that lies in the future.
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
