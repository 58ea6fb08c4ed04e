// SPDX-License-Identifier: Zlib
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>

#include "BulletISTCollision/Core/Base/Pose.h"

namespace devicebridge
{
/// Energy through the hand's six degrees of freedom [J].
struct EnergyLog
{
	double stored = 0;        ///< given by the hand and not returned; below zero the virtual world is active
	double generated = 0;     ///< all that was returned beyond what was given
	double dissipated = 0;    ///< by the controller's damping
	std::uint64_t ticks = 0;  ///< on which it damped
};

struct PassivityLimits
{
	double damping = 0, angularDamping = 0;  ///< the most that the device bears [N s/m, N m s/rad]
	double tolerance = 0;                    ///< energy that quantised positions can feign [J]
	double force = 0, torque = 0;            ///< peaks; a thousandth of them counts as no force [N, N m]
	/// Largest credit [J]. Infinite: a world may return all that it was given, however late; an instability that sets in
	/// after long friction is then met late as well. The credit is forgotten whenever the hand rests without force.
	double largestCredit = std::numeric_limits<double>::infinity();
};

/// Observer and controller after Hannaford and Ryu, on all six degrees of freedom at once. The wrench is held between two
/// samples, so its work is exactly wrench times displacement; it is counted when the second sample arrives. A debt E < 0 is
/// paid back by the damping wrench -beta (b v, b_a w) with the smallest beta in [0, 1] that pays it in one tick.
class PassivityController
{
public:
	explicit PassivityController(const PassivityLimits& limits) : m_limits(limits) {}

	/// A new sample, before correct().
	void observe(const ist::Pose& X_WH) noexcept;
	/// Adds damping when there is a debt, of at most `share` of the device's; true when it did. `dt` [s] until the next sample.
	bool correct(ist::Wrench& wrench, const ist::Twist& twist, double dt, double share = 1) noexcept;
	/// What goes to the hand until the next sample.
	void sent(const ist::Wrench& wrench, const ist::Twist& twist, double dt) noexcept;
	/// That has not gone to the hand.
	void takeBack() noexcept;
	/// The work since the last sample is unknown: begins anew, without credit or debt.
	void forget() noexcept;

	/// From any thread.
	EnergyLog energy() const noexcept;

private:
	static constexpr double kRestingAfter = 0.05;  // [s]
	static constexpr double kRestingSpeed = 5e-3;  // [m/s]
	static constexpr double kRestingTurn = 5e-2;   // [rad/s]

	PassivityLimits m_limits;
	ist::Pose m_pose;
	ist::Wrench m_held;
	bool m_hasPose = false;
	double m_energy = 0, m_resting = 0;
	double m_generatedSum = 0, m_dissipatedSum = 0, m_lastDissipated = 0;
	std::atomic<double> m_stored{0}, m_generated{0}, m_dissipated{0};
	std::atomic<std::uint64_t> m_ticks{0};
};
}  // namespace devicebridge
