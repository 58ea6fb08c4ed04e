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
		10'000'000;  ///< age of a repeated sample [ns]; a SteppingThread waits for at least three periods of its device
	/// Rotation that is a fault if the position stays the same to the last bit for `turnInPlaceAfter` [ns] [rad]: a device without
	/// calibration reports that. 0: not checked, but by a SteppingThread from 0.5 rad on, for devices that exert forces and tremble
	/// (DeviceInfo::turnsInPlace). Negative: never.
	double longestTurnInPlace = 0;
	std::int64_t turnInPlaceAfter = 300'000'000;
	int steadySamples = 20;  ///< number of consecutive good samples before the device is trusted again
};

/// Checks the samples of a device for a pose that is not rigid, a jump, samples that repeat or that were old when they came, and a position
/// that stands still while the handle turns.
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
	bool turnsInPlace(const DeviceState& state, std::int64_t now) noexcept;

	SampleMonitorSettings m_settings;
	DeviceState m_last;
	std::int64_t m_lastFresh = 0, m_placeSince = 0;
	ist::Pose m_place;   // pose when the position last changed
	int m_distrust = 0;  ///< number of good samples still needed after a jump
	bool m_hasLast = false;
};
}  // namespace devicebridge
