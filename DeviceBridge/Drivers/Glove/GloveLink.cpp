// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Glove/GloveLink.h"

#include <algorithm>
#include <cmath>

#include "DeviceBridge/Timing/Clock.h"

namespace devicebridge
{
namespace
{
constexpr int kWait = 5;                             // [ms]
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
		const Event event = takeBytes(kWait);
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
DeviceLink::Event GloveLink::takeBytes(int patience) noexcept
{
	std::uint8_t bytes[256];
	const int n = m_line.read(bytes, sizeof bytes, patience);
	if (n < 0)
	{
		m_complaint = "the serial line " + m_settings.line + " of the glove has hung up";
		return Event::Lost;
	}
	bool found = false;
	for (int i = 0; i < n; ++i) found |= m_frames.take(bytes[i]);
	return found ? Event::Sample : Event::Nothing;
}

ist::Result<GloveValues> GloveLink::meanValues(int frames)
{
	std::array<double, kGloveSensors> sum{};
	const RealClock clock;
	std::int64_t deadline = clock.now() + kFirstFrame;
	for (int n = 0; n < frames;)
	{
		const Event event = takeBytes(kWait);
		if (event == Event::Lost) return ist::Error{m_complaint, false};
		if (clock.now() > deadline) return ist::Error{"the glove on " + m_settings.line + " has fallen silent", false};
		if (event != Event::Sample) continue;
		for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += m_frames.values()[i];
		++n;
		deadline = clock.now() + kFirstFrame;
	}
	GloveValues mean;
	for (std::size_t i = 0; i < mean.size(); ++i) mean[i] = static_cast<std::uint8_t>(std::lround(sum[i] / std::max(1, frames)));
	return mean;
}

DeviceLink::Event GloveLink::exchange(const DeviceCommand&, DeviceSample& sample) noexcept
{
	const Event event = takeBytes(kWait);
	if (event != Event::Sample) return event;
	sample.hand = gloveHand(m_settings.calibration.angles(m_frames.values()), m_settings.size);
	sample.state.velocityEstimated = true;
	if (!m_settings.calibrated) sample.state.flags &= ~static_cast<std::uint32_t>(kCalibrated);
	return event;
}
}  // namespace devicebridge
