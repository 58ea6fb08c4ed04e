// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Device/Device.h"
#include "DeviceBridge/Safety/FaultCause.h"

namespace devicebridge
{
/// The lengths and speeds are those in the frame of the samples. A SteppingThread reads them as those of the handle, and multiplies them by
/// the scale of the device (DeviceInfo::scale).
struct SampleMonitorSettings
{
	double longestJump = 0.05;  ///< largest distance between two samples beyond what `speed` explains [m]
	double speed = 10;          ///< speed that a hand never reaches [m/s]
	double movingSpeed = 0.02;  ///< speed above which two samples of the same pose repeat each other [m/s]
	double longestTurn = 1;     ///< largest rotation between two samples beyond what `angularSpeed` explains [rad]
	double angularSpeed = 100;  ///< angular speed that a hand never reaches [rad/s]
	std::int64_t frozenAfter =
		10'000'000;  ///< age of a repeated sample [ns]; a SteppingThread waits for at least three periods of its device
	/// Largest rotation while the position stays the same to the last bit [rad]. A device that was not calibrated may report such samples.
	/// The position must have stayed the same for `turnInPlaceAfter` [ns]. If the value is 0, a SteppingThread takes 0.5 rad for a device
	/// that exerts forces and whose held handle trembles (DeviceInfo::turnsInPlace is false). Otherwise 0 or less means no check.
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
