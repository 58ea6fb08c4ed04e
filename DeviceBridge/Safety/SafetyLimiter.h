// SPDX-License-Identifier: Zlib
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>

#include "DeviceBridge/Device/Device.h"
#include "DeviceBridge/Safety/AgeFade.h"
#include "DeviceBridge/Safety/GainRamp.h"
#include "DeviceBridge/Safety/HeatBudget.h"
#include "DeviceBridge/Safety/PassivityController.h"
#include "DeviceBridge/Safety/SpeedBrake.h"
#include "DeviceBridge/Safety/StartInsideLatch.h"

namespace devicebridge
{
struct SafetySettings
{
	std::int64_t fullUntil = 5'000'000;   ///< age up to which a command counts in full [ns]
	std::int64_t zeroFrom = 20'000'000;   ///< age from which it counts as zero; linear between the two [ns]
	std::int64_t rampTime = 500'000'000;  ///< time from zero to full gain after enabling, reconnecting and gaps [ns]
	bool startInsideLatch = true;         ///< whether a tool that is in contact when forces are enabled gets no force until it is free
	bool passivity = true;
	double largestCredit = std::numeric_limits<double>::infinity();  ///< PassivityLimits::largestCredit [J]
	std::int64_t riseTime = 20'000'000;                              ///< shortest time from zero to the peak of the device [ns]
	bool oneFactor = false;                                          ///< whether saturation scales force and torque by the same factor
	double heatTime = 10;                                            ///< time constant over which the continuous limits hold [s]
	double maxSpeed = 1.5, maxAngularSpeed = 20;  ///< speeds of the handle above which the device only damps [m/s, rad/s]
	bool latchFault = true;                       ///< whether a wrench that is not finite keeps the device at zero until clearFault()
};

/// Number of commands that each stage changed.
struct SafetyCounts
{
	std::uint64_t notFinite = 0, faulted = 0, aged = 0, disabled = 0, ramped = 0, startInside = 0, notActuated = 0;
	std::uint64_t passivity = 0, slewed = 0, saturated = 0, heat = 0, overSpeed = 0;
	std::uint64_t total() const
	{
		return notFinite + faulted + aged + disabled + ramped + startInside + notActuated + passivity + slewed + saturated + heat +
			overSpeed;
	}
};

/// The data of the hand that the limiter needs besides the command.
struct HandSample
{
	ist::Pose X_WH;
	ist::Twist twist;
	std::uint32_t flags = kReady;
	bool inContact = false;
};

/// The last stage before a device. Stages in order: finite, enabled, age, start-inside latch, ramp, actuated degrees of freedom, passivity,
/// slew, saturation, continuous budget, over-speed brake. The grip force sent is always zero, because no stage limits it.
class SafetyLimiter
{
public:
	explicit SafetyLimiter(const DeviceInfo& info, const SafetySettings& settings = {});

	/// The command to send at `now` [ns]. A command computed later than `now` counts as expired.
	DeviceCommand limit(const DeviceCommand& wanted, const HandSample& hand, std::int64_t now) noexcept;
	/// Starts again as after enabling: zero, latch, ramp.
	void restart() noexcept;
	/// Returns a zero command, because the hand is unknown at `now` [ns] or this tick must have no force. The next command rises from zero.
	DeviceCommand zero(const DeviceCommand& wanted, std::int64_t now) noexcept;
	/// Records that the device has refused the last command: it did no work, and the next command rises from zero.
	void takeBack() noexcept;

	// For any thread:
	void enable(bool on) noexcept { m_enabled = on; }
	bool enabled() const noexcept { return m_enabled; }
	void raiseFault() noexcept { m_faulted = true; }
	/// Clears the fault. The force returns as after enabling.
	void clearFault() noexcept { m_faulted = false; }
	bool faulted() const noexcept { return m_faulted; }
	SafetyCounts counts() const noexcept;
	EnergyLog energy() const noexcept { return m_passivity.energy(); }
	/// The larger HeatBudget::load() of force and torque.
	double heatLoad() const noexcept { return m_heatLoad.load(std::memory_order_relaxed); }

private:
	using Counter = std::atomic<std::uint64_t>;

	bool open(const DeviceCommand& wanted, const HandSample& hand) noexcept;
	double elapsed(std::int64_t now) noexcept;
	double fadeIn(ist::Wrench& wrench, const DeviceCommand& wanted, bool inContact, std::int64_t now) noexcept;
	bool dropNotActuated(ist::Wrench& wrench) const noexcept;
	void limitSize(ist::Wrench& wrench, double dt) noexcept;
	void remember(const ist::Wrench& wrench, const ist::Twist& twist, double dt) noexcept;

	DeviceInfo m_info;
	SafetySettings m_settings;
	AgeFade m_age;
	GainRamp m_ramp;
	StartInsideLatch m_inside;
	PassivityController m_passivity;
	HeatBudget m_forceHeat, m_torqueHeat;
	SpeedBrake m_brake;
	ist::Wrench m_last;
	std::int64_t m_lastTime = 0;
	bool m_hasLast = false;
	std::atomic<bool> m_enabled{true}, m_faulted{false};
	std::atomic<double> m_heatLoad{0};
	Counter m_notFinite{0}, m_faultedTicks{0}, m_aged{0}, m_disabled{0}, m_ramped{0}, m_startInside{0}, m_notActuated{0};
	Counter m_passive{0}, m_slewed{0}, m_saturated{0}, m_heat{0}, m_overSpeed{0};
};
}  // namespace devicebridge
