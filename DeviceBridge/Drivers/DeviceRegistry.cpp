// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/DeviceRegistry.h"

#include <optional>
#include <utility>

#include "DeviceBridge/Decorators/ReconnectingDevice.h"
#include "DeviceBridge/Decorators/RestrictedDevice.h"
#include "DeviceBridge/Device/DeviceAddress.h"
#include "DeviceBridge/Drivers/BuiltDrivers.h"

namespace devicebridge
{
namespace
{
using MadeDevice = ist::Result<std::unique_ptr<Device>>;

/// The options of every scheme.
struct SharedOptions
{
	unsigned dof = 0, sense = 0;  // zero: as the device has it
	bool reconnect = false;
};

/// Returns 0, 3 or 6; any other value is an error.
ist::Result<unsigned> takeFreedoms(DeviceAddress& address, const std::string& key)
{
	const std::optional<std::string> text = address.take(key);
	if (!text) return 0U;
	if (*text == "3") return 3U;
	if (*text == "6") return 6U;
	return ist::Error{"The option " + key + "=" + *text + " must be 3 or 6", false};
}

ist::Result<SharedOptions> takeShared(DeviceAddress& address)
{
	SharedOptions options;
	const auto dof = takeFreedoms(address, "dof"), sense = takeFreedoms(address, "sense");
	if (!dof) return dof.error();
	if (!sense) return sense.error();
	options.dof = dof.value();
	options.sense = sense.value();
	const std::string reconnect = address.take("reconnect").value_or("off");
	if (reconnect != "on" && reconnect != "off") return ist::Error{"The option reconnect=" + reconnect + " must be on or off", false};
	options.reconnect = reconnect == "on";
	return options;
}

MadeDevice restricted(std::unique_ptr<Device> device, const SharedOptions& options, const std::string& uri)
{
	if (options.dof == 0 && options.sense == 0) return device;
	const DeviceInfo& info = device->info();
	if (options.dof == 6 && !(info.actuated & kRotation)) return ist::Error{"'" + uri + "' exerts no torque: leave dof=6 out", false};
	if (options.sense == 6 && !(info.sensed & kRotation))
		return ist::Error{"'" + uri + "' senses no orientation: leave sense=6 out", false};
	const unsigned kAll = ~0U, kNoRotation = ~static_cast<unsigned>(kRotation);
	return MadeDevice(std::make_unique<RestrictedDevice>(
		std::move(device), options.sense == 3 ? kNoRotation : kAll, options.dof == 3 ? kNoRotation : kAll));
}
}  // namespace

DeviceRegistry::DeviceRegistry() { addBuiltDrivers(*this); }

bool DeviceRegistry::addScheme(const std::string& scheme, Maker maker, const std::string& what, Probe missing)
{
	if (scheme.empty() || scheme.find(':') != std::string::npos || !maker) return false;
	return m_schemes.emplace(scheme, Scheme{std::move(maker), what, std::move(missing)}).second;
}

bool DeviceRegistry::addMissing(const std::string& scheme, const std::string& what, const std::string& why)
{
	const auto refuse = [scheme, why](const std::string&) { return MadeDevice(ist::Error{"There is no " + scheme + ": " + why, false}); };
	return addScheme(scheme, refuse, what, [why] { return why; });
}

std::vector<std::string> DeviceRegistry::schemes() const
{
	std::vector<std::string> names;
	for (const auto& entry : m_schemes) names.push_back(entry.first);
	return names;
}

std::vector<DriverReport> DeviceRegistry::drivers() const
{
	std::vector<DriverReport> reports;
	for (const auto& [name, scheme] : m_schemes) reports.push_back({name, scheme.what, scheme.missing ? scheme.missing() : std::string()});
	return reports;
}

MadeDevice DeviceRegistry::open(const std::string& uri) const
{
	const auto colon = uri.find(':');
	const auto found = m_schemes.find(uri.substr(0, colon));
	if (colon == std::string::npos || found == m_schemes.end())
	{
		std::string known;
		for (const auto& entry : m_schemes) known += (known.empty() ? "" : ", ") + entry.first + ":";
		return ist::Error{"No device scheme matches '" + uri + "'; known schemes are " + known, false};
	}
	DeviceAddress address(uri.substr(colon + 1));
	const auto options = takeShared(address);
	if (!options) return options.error();
	MadeDevice made = found->second.maker(address.rest());
	if (!made) return made;
	if (!made.value()) return ist::Error{"The scheme of '" + uri + "' made no device", false};
	std::unique_ptr<Device> device = std::move(made).value();
	if (options.value().reconnect) device = std::make_unique<ReconnectingDevice>(std::move(device));
	const DeviceStatus status = device->open();
	if (status != DeviceStatus::Ok)
	{
		const std::string why = device->complaint();
		return ist::Error{"Cannot open '" + uri + "': " + (why.empty() ? std::string(describe(status)) : why), false};
	}
	return restricted(std::move(device), options.value(), uri);
}
}  // namespace devicebridge
