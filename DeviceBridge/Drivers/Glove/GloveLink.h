// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

#include "DeviceBridge/Device/DeviceLink.h"
#include "DeviceBridge/Drivers/Glove/GloveFrames.h"
#include "DeviceBridge/Drivers/Glove/GloveHand.h"
#include "DeviceBridge/Platform/SerialLine.h"

namespace devicebridge
{
struct GloveSettings
{
	std::string line;  ///< serial line, 115200 baud, 8N1
	int sensors = 0;   ///< number of sensors, 18 or 22; zero: the glove's own
	GloveHandSize size;
	GloveCalibration calibration = roughGloveCalibration();
	bool calibrated = false;
};

/// The settings from the part of an address after `glove:`. Reads the calibration file that the address names.
ist::Result<GloveSettings> gloveSettings(const std::string& rest);

/// A CyberGlove on a serial line. It senses the joints of the hand, but neither the hand's position nor velocities, and it exerts no force.
class GloveLink final : public DeviceLink
{
public:
	GloveLink(GloveSettings settings, std::string uri)
		: m_settings(std::move(settings)),
		  m_uri(std::move(uri)),
		  m_frames(m_settings.sensors)
	{}
	~GloveLink() override { disconnect(); }

	ist::Result<DeviceInfo> connect() noexcept override;
	Event exchange(const DeviceCommand& command, DeviceSample& sample) noexcept override;
	void disconnect() noexcept override;
	std::string complaint() const override { return m_complaint; }

	/// Reads less than the length of a frame, so at most one frame ends, and does not wait. Returns Sample if values() are new. Call it and
	/// discardFrames() between connect() and disconnect().
	Event nextFrame() noexcept;
	/// Forgets what has arrived.
	void discardFrames() noexcept;
	const GloveValues& values() const noexcept { return m_frames.values(); }
	int sensors() const noexcept { return m_frames.sensors(); }

private:
	Event takeBytes(int patience, std::size_t most) noexcept;

	GloveSettings m_settings;
	std::string m_uri, m_complaint;
	GloveFrames m_frames;
	SerialLine m_line;
};
}  // namespace devicebridge
