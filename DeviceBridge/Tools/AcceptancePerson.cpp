// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Tools/AcceptancePerson.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <memory>

#include "DeviceBridge/Decorators/DeviceDecorator.h"

namespace devicebridge::tools
{
namespace
{
constexpr std::int64_t kTick = 1'000'000;                // [ns]
constexpr int kMeanTicks = 100, kSimulatedTicks = 2000;  // of a sample; the hand of a simulated device moves meanwhile

std::string trimmed(std::string text)
{
	const auto isSpace = [](unsigned char c) { return std::isspace(c) != 0; };
	text.erase(text.begin(), std::find_if_not(text.begin(), text.end(), isSpace));
	text.erase(std::find_if_not(text.rbegin(), text.rend(), isSpace).base(), text.end());
	return text;
}
}  // namespace

AcceptancePerson::AcceptancePerson(Device& device, Clock& clock) : m_device(device), m_clock(clock)
{
	Device* innermost = &device;
	while (auto* decorator = dynamic_cast<DeviceDecorator*>(innermost)) innermost = &decorator->inner();
	m_simulated = dynamic_cast<SimulatedDevice*>(innermost);
}

void AcceptancePerson::tell(const std::string& text) const { std::fprintf(stderr, "%s\n", text.c_str()); }

std::optional<std::string> AcceptancePerson::ask(const std::string& question)
{
	std::fprintf(stderr, "%s: ", question.c_str());
	std::fflush(stderr);
	std::string line;
	int c = std::getchar();
	for (; c != '\n' && c != EOF; c = std::getchar())
		if (line.size() < 1000) line.push_back(static_cast<char>(c));
	if (c == EOF && line.empty()) return std::nullopt;
	return trimmed(line);
}

void AcceptancePerson::move(const ist::Vec3& by, const ist::Vec3& turn, double seconds, double wait)
{
	if (!m_simulated) return;
	const ist::Pose from = m_hand;
	m_hand = {rotationMatrix(ist::quaternionFromRotationVector(turn)) * from.rotation, from.translation + by};
	const HandScript way = handThrough({{wait, from}, {wait + seconds, m_hand}});
	// The script's time is that of the device since its first sample.
	m_simulated->setHand([way, begin = std::make_shared<std::optional<double>>()](double t) {
		if (!*begin) *begin = t;
		return way(t - **begin);
	});
}

void AcceptancePerson::unplug()
{
	if (m_simulated) m_simulated->close();
}

void AcceptancePerson::plugIn()
{
	if (m_simulated) m_simulated->open();
}

ist::Result<DeviceState> AcceptancePerson::sample()
{
	DeviceState state, mean;
	ist::Vec3 sum;
	const int all = kMeanTicks + (m_simulated ? kSimulatedTicks : 0);
	const std::int64_t begin = m_clock.now();
	for (int i = 0; i < all; ++i)
	{
		m_clock.sleepUntil(begin + i * kTick);
		const DeviceStatus status = m_device.read(m_clock.now(), state);
		if (status == DeviceStatus::Ok && !isRigid(state.X_WH)) return ist::Error{describe(DeviceStatus::InvalidState), false};
		if (status != DeviceStatus::Ok)
		{
			const std::string complaint = m_device.complaint();
			return ist::Error{std::string(describe(status)) + (complaint.empty() ? "" : ": " + complaint), false};
		}
		if (i >= all - kMeanTicks) sum += state.X_WH.translation;
	}
	mean = state;
	mean.X_WH.translation = sum / kMeanTicks;
	return mean;
}
}  // namespace devicebridge::tools
