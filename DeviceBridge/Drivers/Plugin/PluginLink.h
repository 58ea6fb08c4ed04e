// SPDX-License-Identifier: Zlib
#pragma once

#include <array>
#include <string>

#include "DeviceBridge/Device/DeviceLink.h"
#include "DeviceBridge/Plugins/devicebridge_plugin.h"

namespace devicebridge
{
/// A device of a plug-in. SampleMonitor and SafetyLimiter check its samples as those of any device.
class PluginLink final : public DeviceLink
{
public:
	PluginLink(const devicebridge_plugin& plugin, std::string address, std::string uri);
	~PluginLink() override { disconnect(); }

	ist::Result<DeviceInfo> connect() noexcept override;
	Event exchange(const DeviceCommand& command, DeviceSample& sample) noexcept override;
	void disconnect() noexcept override;
	std::string complaint() const override;

private:
	const devicebridge_plugin& m_plugin;
	std::string m_address, m_uri;
	void* m_device = nullptr;
	devicebridge_state m_state{};
	std::array<char, 512> m_why{};
	bool m_hasHand = false;
};
}  // namespace devicebridge
