// SPDX-License-Identifier: Zlib
#pragma once

#include <atomic>
#include <cstdint>

#include "DeviceBridge/Device.h"

namespace devicebridge
{
struct SafetySettings
{
	std::int64_t fullUntil = 5'000'000;   ///< age up to which a command counts in full [ns]
	std::int64_t zeroFrom = 20'000'000;   ///< age from which it counts as zero; linear between the two [ns]
	std::int64_t riseTime = 20'000'000;   ///< shortest time from zero to the peak of the device [ns]
	bool latchFault = true;               ///< a wrench that was not finite keeps the device at zero until clearFault()
};

/// How often each stage changed a command.
struct SafetyCounts
{
	std::uint64_t notFinite = 0, faulted = 0, aged = 0, slewed = 0, saturated = 0, notActuated = 0;
	std::uint64_t total() const { return notFinite + faulted + aged + slewed + saturated + notActuated; }
};

/// Last station before a device. Stages in order: finite, age, actuated degrees of freedom, saturation,
/// slew (the direction is kept by saturation). Grip force is not limited yet and therefore not passed on.
/// Force and torque are limited separately.
class SafetyLimiter
{
public:
	explicit SafetyLimiter(const DeviceInfo& info, const SafetySettings& settings = {});

	/// The command to send at `now` [ns]. A command computed later than `now` counts as expired.
	DeviceCommand limit(const DeviceCommand& wanted, std::int64_t now) noexcept;
	/// Forgets the last wrench: the next one rises from zero.
	void reset() noexcept;
	void raiseFault() noexcept { m_faulted = true; }
	void clearFault() noexcept { m_faulted = false; }
	bool faulted() const noexcept { return m_faulted; }
	/// May be called from any thread while another limits.
	SafetyCounts counts() const noexcept;

private:
	using Counter = std::atomic<std::uint64_t>;

	double ageFactor(const DeviceCommand& wanted, std::int64_t now) const noexcept;
	bool dropNotActuated(ist::Wrench& wrench) const noexcept;

	DeviceInfo m_info;
	SafetySettings m_settings;
	ist::Wrench m_last;
	std::int64_t m_lastTime = 0;
	bool m_hasLast = false;
	std::atomic<bool> m_faulted{false};
	Counter m_notFinite{0}, m_faultedTicks{0}, m_aged{0}, m_slewed{0}, m_saturated{0}, m_notActuated{0};
};
}  // namespace devicebridge
