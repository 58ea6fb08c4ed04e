// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Hand/HandModel.h"
#include "DeviceBridge/Hand/HandSampleFault.h"

#include <cstdint>
#include <string>

namespace devicebridge
{
struct HandTrackingLimits
{
	double speed = 4;       ///< largest speed of a part's target [m/s]; a faster motion is a jump, which is followed at this speed
	double turning = 40;    ///< largest angular speed of a part's target [rad/s]
	double patience = 0.3;  ///< time for which a lost hand keeps its grip [s]
	/// Time after which a hand whose joints repeat bit for bit counts as lost [s]; 0: never. A real hand always trembles. Set it for
	/// tracked hands and gloves, and not for scripted ones, which may rest.
	double frozenAfter = 0;
	double fade = 0.5;  ///< time in which the grip then decreases to zero [s]; it returns in a quarter of this time
};

/// Problems with the samples of a hand, as numbers of ticks.
struct HandComplaints
{
	std::uint64_t missingJoints = 0;  ///< ticks in which parts were missing and stayed at their last pose on the known palm
	std::uint64_t lost = 0;           ///< ticks without a known palm, in which the whole hand stood still
	std::uint64_t jumps = 0;          ///< ticks in which a part was further away than the limits allow
	std::uint64_t wrongSide = 0;      ///< ticks with a sample of the other hand, which was not used
	std::array<std::uint64_t, static_cast<std::size_t>(HandSampleFault::Count)> faulty{};  ///< ticks with a sample of this fault, which
																						   ///< counts as a lost hand
	std::uint64_t ticks = 0;

	std::uint64_t of(HandSampleFault fault) const { return faulty[static_cast<std::size_t>(fault)]; }
	/// The problems in words: "tracking was lost for 120 of 1000 ticks, ..."; empty if there were none.
	std::string sentence() const;
};

/// Turns samples of a hand, in any state, into targets that a coupling can follow: finite, rigid, continuous. A missing part stays at its
/// last pose on the palm. Without the palm, and with a sample that cannot be this hand (faultOf), the whole hand stands still and, after a
/// while, releases its grip. No allocation.
class HandTrackingMonitor
{
public:
	struct Target
	{
		ist::Pose X_WB;
		ist::Twist twist;  ///< velocity of the target in its last step
	};

	/// The hand begins at `start`, in which all parts are known. The model must outlive this object.
	HandTrackingMonitor(const HandModel& model, const HandPartPoses& start, const HandTrackingLimits& limits = {});

	/// Moves the targets to `hand` within the limits. `dt` [s] is positive.
	void update(const HandState& hand, double dt) noexcept;
	const Target& target(int part) const noexcept { return m_targets[static_cast<std::size_t>(part)]; }
	/// Factor for the stiffness of the coupling, 0 to 1.
	double grip() const noexcept { return m_grip; }
	const HandComplaints& complaints() const noexcept { return m_complaints; }

private:
	bool moveTowards(Target& target, const ist::Pose& X_WB, double dt) const noexcept;
	HandSampleFault judge(const HandState& hand, double dt) noexcept;

	const HandModel& m_model;
	HandTrackingLimits m_limits;
	HandPartPoses m_last;  // last poses; the palm carries those of missing parts along
	std::array<Target, kHandParts> m_targets;
	double m_grip = 1, m_lostFor = 0;
	HandState m_sample;    // newest sample that differed from the one before
	double m_sameFor = 0;  // time for which it has repeated [s]
	HandComplaints m_complaints;
};

// Former names, kept until 0.4.
using HandWatch [[deprecated("since 0.3: HandTrackingMonitor")]] = HandTrackingMonitor;
using HandWatchLimits [[deprecated("since 0.3: HandTrackingLimits")]] = HandTrackingLimits;
}  // namespace devicebridge
