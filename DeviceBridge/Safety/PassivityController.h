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
	double stored = 0;        ///< energy that the hand has given and not received back; below zero the virtual world is active
	double generated = 0;     ///< sum of the energy returned beyond what the hand had given
	double dissipated = 0;    ///< energy dissipated by the controller's damping
	std::uint64_t ticks = 0;  ///< number of ticks with that damping
};

struct PassivityLimits
{
	double damping = 0, angularDamping = 0;  ///< largest damping that the device bears [N s/m, N m s/rad]
	double tolerance = 0;                    ///< energy error that quantised positions can cause [J]
	double force = 0, torque = 0;            ///< peaks; below a thousandth of them the wrench counts as zero [N, N m]
	/// Largest credit [J]. If infinite, a world may return all the energy that it was given, however late. An instability that begins after
	/// long friction is then damped late, too. The credit is cleared whenever the hand rests without force.
	double largestCredit = std::numeric_limits<double>::infinity();
};

/// Passivity observer and controller after Hannaford and Ryu, for all six degrees of freedom together. The wrench is held between two
/// samples, so its work is exactly wrench times displacement. This work is counted when the second sample arrives. A debt E < 0 is paid
/// back by the damping wrench -beta (b v, b_a w), with the smallest beta in [0, 1] that pays it in one tick.
class PassivityController
{
public:
	explicit PassivityController(const PassivityLimits& limits) : m_limits(limits) {}

	/// Takes a new sample; call it before correct().
	void observe(const ist::Pose& X_WH) noexcept;
	/// Adds damping if there is a debt, at most `share` of the device's limit. Returns true if it did. `dt` is the time until the next
	/// sample [s].
	bool correct(ist::Wrench& wrench, const ist::Twist& twist, double dt, double share = 1) noexcept;
	/// Records the wrench that the hand receives until the next sample.
	void sent(const ist::Wrench& wrench, const ist::Twist& twist, double dt) noexcept;
	/// Revokes the last sent(), because the wrench did not reach the hand.
	void takeBack() noexcept;
	/// Starts again without credit or debt, because the work since the last sample is unknown.
	void forget() noexcept;

	/// For any thread.
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
