// SPDX-License-Identifier: Zlib
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Device/Device.h"

namespace devicebridge
{
/// A scheme and whether a device can be had by it at the moment.
struct DriverReport
{
	std::string scheme, what;
	std::string missing;  ///< why no device can be had and what to do about it; empty when nothing stands in the way
};

/// Opens devices by address, `SCHEME:REST`, any number of them side by side. `devicebridge list` shows the schemes that it knows
/// from the start. Options of every scheme, behind a question mark:
///   dof=3, dof=6        force alone, or force and torque; refused where the device lacks what is asked for
///   sense=3, sense=6    position alone, or position and orientation
///   reconnect=on        a ReconnectingDevice
class DeviceRegistry
{
public:
	/// Receives the address behind the colon without the options above; the device that it makes is not open yet.
	using Maker = std::function<ist::Result<std::unique_ptr<Device>>(const std::string& rest)>;
	/// Looks for DriverReport::missing, and leaves nothing open.
	using Probe = std::function<std::string()>;

	DeviceRegistry();
	/// False, and nothing changed, when the scheme is empty, holds a colon or is taken.
	bool addScheme(const std::string& scheme, Maker maker, const std::string& what = {}, Probe missing = {});
	/// A scheme that this build or this system lacks altogether: it is listed, and opening gives the reason.
	bool addMissing(const std::string& scheme, const std::string& what, const std::string& why);
	std::vector<std::string> schemes() const;
	std::vector<DriverReport> drivers() const;
	/// The device, opened.
	ist::Result<std::unique_ptr<Device>> open(const std::string& uri) const;

private:
	struct Scheme
	{
		Maker maker;
		std::string what;
		Probe missing;
	};
	std::map<std::string, Scheme> m_schemes;
};
}  // namespace devicebridge
