// SPDX-License-Identifier: Zlib
#include "DeviceBridge/DeviceRegistry.h"

#include <utility>

#include "DeviceBridge/Drivers/Replay/ReplayDevice.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"

namespace devicebridge
{
namespace
{
using MadeDevice = ist::Result<std::unique_ptr<Device>>;

MadeDevice makeSimulated(const std::string& rest)
{
	auto profile = simulatedProfile(rest);
	if (!profile) return profile.error();
	return MadeDevice(std::make_unique<SimulatedDevice>(std::move(profile).value()));
}

MadeDevice makeReplay(const std::string& path)
{
	auto recording = loadRecording(path);
	if (!recording) return recording.error();
	return MadeDevice(std::make_unique<ReplayDevice>(std::move(recording).value()));
}
}  // namespace

DeviceRegistry::DeviceRegistry()
{
	addScheme("sim", makeSimulated);
	addScheme("replay", makeReplay);
}

bool DeviceRegistry::addScheme(const std::string& scheme, Maker maker)
{
	if (scheme.empty() || scheme.find(':') != std::string::npos || !maker) return false;
	return m_makers.emplace(scheme, std::move(maker)).second;
}

std::vector<std::string> DeviceRegistry::schemes() const
{
	std::vector<std::string> names;
	for (const auto& entry : m_makers) names.push_back(entry.first);
	return names;
}

MadeDevice DeviceRegistry::open(const std::string& uri) const
{
	const auto colon = uri.find(':');
	const auto found = m_makers.find(uri.substr(0, colon));
	if (colon == std::string::npos || found == m_makers.end())
	{
		std::string known;
		for (const auto& entry : m_makers) known += (known.empty() ? "" : ", ") + entry.first + ":";
		return ist::Error{"No device scheme matches '" + uri + "'; known schemes are " + known, false};
	}
	MadeDevice made = found->second(uri.substr(colon + 1));
	if (!made) return made;
	if (!made.value()) return ist::Error{"The scheme of '" + uri + "' made no device", false};
	const DeviceStatus status = made.value()->open();
	if (status != DeviceStatus::Ok)
		return ist::Error{"Cannot open '" + uri + "': " + std::string(describe(status)), false};
	return made;
}
}  // namespace devicebridge
