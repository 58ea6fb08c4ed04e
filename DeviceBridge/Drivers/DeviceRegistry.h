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
/// A scheme, and whether it can open a device at the moment.
struct DriverReport
{
	std::string scheme, what;
	std::string missing;  ///< reason why no device is available, and what to do; empty if there is none
};

/// Opens devices by address, `SCHEME:REST`; any number may be open at the same time. `devicebridge list` shows the built-in schemes.
/// Options of every scheme, after a question mark:
///   dof=3, dof=6        force alone, or force and torque; refused if the device lacks what is required
///   sense=3, sense=6    position alone, or position and orientation
///   reconnect=on        a ReconnectingDevice
class DeviceRegistry
{
public:
	/// Makes a device that is not open yet. It receives the address after the colon without the options above.
	using Maker = std::function<ist::Result<std::unique_ptr<Device>>(const std::string& rest)>;
	/// Determines DriverReport::missing, and leaves nothing open.
	using Probe = std::function<std::string()>;

	DeviceRegistry();
	/// Returns false and changes nothing if the scheme is empty, contains a colon or exists already.
	bool addScheme(const std::string& scheme, Maker maker, const std::string& what = {}, Probe missing = {});
	/// Adds a scheme that this build or system lacks altogether. It is listed, and opening it returns the reason.
	bool addMissing(const std::string& scheme, const std::string& what, const std::string& why);
	std::vector<std::string> schemes() const;
	std::vector<DriverReport> drivers() const;
	/// Makes and opens a device.
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
