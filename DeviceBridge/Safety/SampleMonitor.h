// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Device/Device.h"
#include "DeviceBridge/Safety/FaultCause.h"

namespace devicebridge
{
struct SampleMonitorSettings
{
	double longestJump = 0.05;  ///< between two samples beyond what `speed` explains [m]
	double speed = 10;          ///< that a hand never has [m/s]
	double longestTurn = 1;     ///< between two samples beyond what `angularSpeed` explains [rad]
	double angularSpeed = 100;  ///< that a hand never has [rad/s]
	std::int64_t frozenAfter =
		10'000'000;          ///< age of a repeated sample [ns]; a SteppingThread waits for at least three periods of its device
	int steadySamples = 20;  ///< good ones in a row before the device is believed again
};

/// Judges the samples of a device: a pose that is not rigid, a jump, samples that repeat.
class SampleMonitor
{
public:
	explicit SampleMonitor(const SampleMonitorSettings& settings = {}) : m_settings(settings) {}

	/// What is wrong with a sample that was read at `now` [ns].
	FaultCause judge(const DeviceState& state, std::int64_t now) noexcept;
	/// The next sample may be anywhere.
	void forget() noexcept { m_hasLast = false; }

private:
	bool repeats(const DeviceState& state) const noexcept;
	bool jumped(const DeviceState& state, double seconds) const noexcept;

	SampleMonitorSettings m_settings;
	DeviceState m_last;
	std::int64_t m_lastFresh = 0;
	int m_distrust = 0;  ///< good samples still wanted after a jump
	bool m_hasLast = false;
};
}  // namespace devicebridge
