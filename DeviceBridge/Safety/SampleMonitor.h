// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Device/Device.h"
#include "DeviceBridge/Safety/FaultCause.h"

namespace devicebridge
{
struct SampleMonitorSettings
{
	double longestJump = 0.05;  ///< largest distance between two samples beyond what `speed` explains [m]
	double speed = 10;          ///< speed that a hand never reaches [m/s]
	double longestTurn = 1;     ///< largest rotation between two samples beyond what `angularSpeed` explains [rad]
	double angularSpeed = 100;  ///< angular speed that a hand never reaches [rad/s]
	std::int64_t frozenAfter =
		10'000'000;          ///< age of a repeated sample [ns]; a SteppingThread waits for at least three periods of its device
	int steadySamples = 20;  ///< number of consecutive good samples before the device is trusted again
};

/// Checks the samples of a device for a pose that is not rigid, a jump, and samples that repeat.
class SampleMonitor
{
public:
	explicit SampleMonitor(const SampleMonitorSettings& settings = {}) : m_settings(settings) {}

	/// The fault of a sample that was read at `now` [ns]; None if it is good.
	FaultCause judge(const DeviceState& state, std::int64_t now) noexcept;
	/// Accepts any next sample, because the handle may have moved anywhere.
	void forget() noexcept { m_hasLast = false; }

private:
	bool repeats(const DeviceState& state) const noexcept;
	bool jumped(const DeviceState& state, double seconds) const noexcept;

	SampleMonitorSettings m_settings;
	DeviceState m_last;
	std::int64_t m_lastFresh = 0;
	int m_distrust = 0;  ///< number of good samples still needed after a jump
	bool m_hasLast = false;
};
}  // namespace devicebridge
