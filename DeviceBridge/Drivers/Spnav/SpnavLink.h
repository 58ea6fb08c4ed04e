// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Device/DeviceLink.h"
#include "DeviceBridge/Drivers/Spnav/SpnavMotion.h"

namespace devicebridge
{
/// A 6-DOF mouse behind spacenavd. Its deflection is the velocity of the handle, which is integrated from the origin; it exerts no force.
/// libspnav has one connection for the whole program, so a second device is refused while one is open.
class SpnavLink final : public DeviceLink
{
public:
	SpnavLink(const SpnavRates& rates, std::string uri) : m_rates(rates), m_uri(std::move(uri)) {}
	~SpnavLink() override { disconnect(); }

	ist::Result<DeviceInfo> connect() noexcept override;
	Event exchange(const DeviceCommand& command, DeviceSample& sample) noexcept override;
	void disconnect() noexcept override;
	std::string complaint() const override { return m_complaint; }

private:
	bool takeEvents(std::int64_t now) noexcept;
	void integrate(double dt) noexcept;

	SpnavRates m_rates;
	std::string m_uri, m_complaint;
	bool m_open = false;
	int m_counts[6] = {};
	std::uint32_t m_buttons = 0;
	std::int64_t m_lastEvent = 0, m_lastTime = 0;
	ist::Pose m_pose;
};

/// Why `spnav:` can open no mouse; empty if a daemon answers.
std::string spnavMissing();
}  // namespace devicebridge
