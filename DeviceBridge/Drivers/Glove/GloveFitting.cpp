// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Glove/GloveFitting.h"

#include <cmath>

#include "BulletISTCollision/Core/Asset/AtomicFile.h"
#include "DeviceBridge/Device/DeviceAddress.h"

namespace devicebridge
{
namespace
{
constexpr int kSettling = 50, kMeasured = 50;     // frames that are dropped, and that count; half a second each
constexpr int kMostReads = 64;                    // in one update: 1 kB
constexpr std::int64_t kSilence = 2'000'000'000;  // [ns]
constexpr const char* kPoses[2] = {
	"Lay the hand flat on a table, fingers together, and hold still", "Close the fist, the wrist straight, and hold still"};
}  // namespace

ist::Result<std::unique_ptr<GloveFitting>> GloveFitting::begin(const std::string& address, std::string file)
{
	const std::string scheme = "glove:";
	if (address.rfind(scheme, 0) != 0)
		return ist::Error{"only gloves (glove:/dev/ttyUSB0) are calibrated here; " + address + ": " + howToCalibrate(address), false};
	if (file.empty()) return ist::Error{"name the file for the calibration", false};
	if (auto refused = ist::whyNotWritable(file)) return *refused;
	DeviceAddress rest(address.substr(scheme.size()));
	rest.take("calibration");
	auto settings = gloveSettings(rest.rest());
	if (!settings) return settings.error();
	std::unique_ptr<GloveFitting> fitting(new GloveFitting(std::move(settings).value(), scheme + rest.rest(), std::move(file)));
	const auto found = fitting->m_glove.connect();
	if (!found) return found.error();
	fitting->m_heard = fitting->m_clock.now();
	return fitting;
}

GloveFitting::GloveFitting(GloveSettings settings, const std::string& address, std::string file)
	: m_glove(std::move(settings), address),
	  m_file(std::move(file)),
	  m_calibrated(address + (address.find('?') == std::string::npos ? "?" : "&") + "calibration=" + m_file)
{}

std::string GloveFitting::order() const
{
	switch (m_state)
	{
	case State::Pose: return kPoses[m_pose];
	case State::Measuring: return "Hold still";
	case State::Written: return m_file + " is written; the calibrated glove is " + m_calibrated;
	case State::Failed: break;
	}
	return {};
}

void GloveFitting::confirm()
{
	if (m_state != State::Pose) return;
	m_glove.discardFrames();
	m_sum = {};
	m_frames = 0;
	m_heard = m_clock.now();
	m_state = State::Measuring;
}

GloveFitting::State GloveFitting::update()
{
	for (int i = 0; i < kMostReads && (m_state == State::Pose || m_state == State::Measuring); ++i)
	{
		const DeviceLink::Event event = m_glove.nextFrame();
		if (event == DeviceLink::Event::Lost) return fail(m_glove.complaint());
		if (event == DeviceLink::Event::Sample) take(m_glove.values());
	}
	const bool listens = m_state == State::Pose || m_state == State::Measuring;
	if (listens && m_clock.now() - m_heard > kSilence) return fail("the glove has fallen silent");
	return m_state;
}

void GloveFitting::take(const GloveValues& values)
{
	m_heard = m_clock.now();
	if (m_state != State::Measuring || ++m_frames <= kSettling) return;
	for (std::size_t i = 0; i < m_sum.size(); ++i) m_sum[i] += values[i];
	if (m_frames < kSettling + kMeasured) return;
	for (std::size_t i = 0; i < m_sum.size(); ++i) m_held[m_pose][i] = static_cast<std::uint8_t>(std::lround(m_sum[i] / kMeasured));
	m_state = State::Pose;
	if (++m_pose == 2) write();
}

void GloveFitting::write()
{
	const auto made = calibrateGlove(m_held[0], m_held[1], m_glove.sensors() == kGloveSensors);
	m_glove.disconnect();
	if (!made)
	{
		fail(made.error().message);
		return;
	}
	const std::string text = writeGloveCalibration(made.value());
	const auto written = ist::writeFileAtomically(m_file, reinterpret_cast<const std::byte*>(text.data()), text.size());
	if (written) m_state = State::Written;
	else fail(written.error().message);
}

GloveFitting::State GloveFitting::fail(std::string why)
{
	m_glove.disconnect();
	m_complaint = std::move(why);
	return m_state = State::Failed;
}
}  // namespace devicebridge
