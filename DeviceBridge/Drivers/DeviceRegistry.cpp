// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/DeviceRegistry.h"

#include <optional>
#include <utility>

#include "DeviceBridge/Decorators/ClutchedDevice.h"
#include "DeviceBridge/Decorators/MountedDevice.h"
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
	int clutch = 0;  // number of the button, from 1 on; zero: none
	double scale = 1;
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
	const auto clutch = address.takeNumber("clutch", 0, 1, 32), scale = address.takeNumber("scale", 1, 0.01, 100);
	if (!clutch) return clutch.error();
	if (!scale) return scale.error();
	options.clutch = static_cast<int>(clutch.value());
	if (options.clutch != clutch.value()) return ist::Error{"The option clutch must be the number of a button, 1 to 32", false};
	options.scale = scale.value();
	return options;
}

/// Scales the device, and then lets the clutch shift what is scaled.
std::unique_ptr<Device> placed(std::unique_ptr<Device> device, const SharedOptions& options)
{
	if (options.scale != 1) device = std::make_unique<MountedDevice>(std::move(device), ist::Pose(), options.scale);
	if (options.clutch > 0) device = std::make_unique<ClutchedDevice>(std::move(device), std::uint32_t{1} << (options.clutch - 1));
	return device;
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
	MadeDevice allowed = restricted(std::move(device), options.value(), uri);
	if (!allowed) return allowed;
	return MadeDevice(placed(std::move(allowed).value(), options.value()));
}
}  // namespace devicebridge
