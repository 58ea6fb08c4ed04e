// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Glove/GloveLink.h"

#include <algorithm>

#include "DeviceBridge/Timing/Clock.h"

namespace devicebridge
{
namespace
{
constexpr int kWait = 5;                             // [ms]
constexpr std::size_t kMostBytes = 256;              // of one read
constexpr std::size_t kPartOfAFrame = 16;            // the shorter frame has 20 bytes
constexpr int kMostReads = 1000;                     // while bytes are discarded
constexpr std::int64_t kSettling = 300'000'000;      // wait after a command [ns]
constexpr std::int64_t kFirstFrame = 2'000'000'000;  // [ns]
constexpr const char *kStop = "\x03", *kNoStatus = "u 0\r", *kStream = "S";
}  // namespace

ist::Result<DeviceInfo> GloveLink::connect() noexcept
{
	const std::string& line = m_settings.line;
	if (const std::string why = m_line.open(line); !why.empty()) return ist::Error{why, false};
	RealClock clock;
	m_line.write(kStop);
	m_line.write(kNoStatus);
	clock.sleepUntil(clock.now() + kSettling);
	m_line.discardInput();
	m_frames = GloveFrames(m_settings.sensors);
	if (!m_line.write(kStream)) return ist::Error{"the serial line " + line + " does not take commands", false};
	const std::int64_t deadline = clock.now() + kFirstFrame;
	while (m_frames.sensors() == 0)
	{
		const Event event = takeBytes(kWait, kMostBytes);
		if (event == Event::Lost) return ist::Error{m_complaint, false};
		if (clock.now() > deadline)
			return ist::Error{"what is on " + line + " sends no frames of " +
					(m_settings.sensors ? std::to_string(m_settings.sensors) : std::string("18 or 22")) +
					" sensors; is the glove switched on?",
				false};
	}
	DeviceInfo info;
	info.uri = m_uri;
	info.maker = "CyberGlove Systems", info.model = "CyberGlove, " + std::to_string(m_frames.sensors()) + " sensors";
	info.sensed = kHandJointsSensed;
	info.handedness = m_settings.size.left ? Handedness::Left : Handedness::Right;
	info.nominalRate = 90;
	info.source = "rate: assumed";
	return info;
}

void GloveLink::disconnect() noexcept
{
	if (!m_line.isOpen()) return;
	m_line.write(kStop);
	m_line.close();
}

/// Returns Sample if the bytes completed a frame.
DeviceLink::Event GloveLink::takeBytes(int patience, std::size_t most) noexcept
{
	std::uint8_t bytes[kMostBytes];
	const int n = m_line.read(bytes, std::min(most, kMostBytes), patience);
	if (n < 0)
	{
		m_complaint = "the serial line " + m_settings.line + " of the glove has hung up";
		return Event::Lost;
	}
	bool found = false;
	for (int i = 0; i < n; ++i) found |= m_frames.take(bytes[i]);
	return found ? Event::Sample : Event::Nothing;
}

DeviceLink::Event GloveLink::nextFrame() noexcept { return takeBytes(0, kPartOfAFrame); }

void GloveLink::discardFrames() noexcept
{
	m_line.discardInput();
	// Some systems keep more than a line discards.
	std::uint8_t bytes[kMostBytes];
	for (int i = 0; i < kMostReads && m_line.read(bytes, kMostBytes, 0) > 0; ++i)
	{}
	m_frames.restart();
}

DeviceLink::Event GloveLink::exchange(const DeviceCommand&, DeviceSample& sample) noexcept
{
	const Event event = takeBytes(kWait, kMostBytes);
	if (event != Event::Sample) return event;
	sample.hand = gloveHand(m_settings.calibration.angles(m_frames.values()), m_settings.size);
	sample.state.velocityEstimated = true;
	if (!m_settings.calibrated) sample.state.flags &= ~static_cast<std::uint32_t>(kCalibrated);
	return event;
}
}  // namespace devicebridge
