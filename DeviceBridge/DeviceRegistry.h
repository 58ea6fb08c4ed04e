// SPDX-License-Identifier: Zlib
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "BulletISTCollision/Core/Result.h"
#include "DeviceBridge/Device.h"

namespace devicebridge
{
/// Opens devices by address, `SCHEME:REST`. Knows `sim:PROFILE` and `replay:FILE` from the start.
class DeviceRegistry
{
public:
	/// Receives the address behind the colon; the device that it makes is not open yet.
	using Maker = std::function<ist::Result<std::unique_ptr<Device>>(const std::string& rest)>;

	DeviceRegistry();
	/// False, and nothing changed, when the scheme is empty, holds a colon or is taken.
	bool addScheme(const std::string& scheme, Maker maker);
	std::vector<std::string> schemes() const;
	/// The device, opened.
	ist::Result<std::unique_ptr<Device>> open(const std::string& uri) const;

private:
	std::map<std::string, Maker> m_makers;
};
}  // namespace devicebridge
