// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Hand/HandModel.h"

#include <cstdint>
#include <string>

namespace devicebridge
{
struct HandTrackingLimits
{
	double speed = 4;       ///< fastest that a part's target moves [m/s]; what goes further is a jump, and followed at this speed
	double turning = 40;    ///< and turns [rad/s]
	double patience = 0.3;  ///< so long a hand that is lost keeps its grip [s]
	double fade = 0.5;      ///< then it lets go within [s]; and takes hold again within a quarter of that
};

/// What was wrong with the samples of a hand, in ticks.
struct HandComplaints
{
	std::uint64_t missingJoints = 0;  ///< parts of a hand whose palm is known stayed in their last place on it
	std::uint64_t lost = 0;           ///< the palm was not known: the whole hand stood still
	std::uint64_t jumps = 0;          ///< a part was further away than the limits allow
	std::uint64_t wrongSide = 0;      ///< the sample was of the other hand, and not used
	std::uint64_t ticks = 0;

	/// In words: "tracking was lost for 120 of 1000 ticks, ..."; empty when all was well.
	std::string sentence() const;
};

/// Turns samples of a hand, whatever their state, into targets that a coupling can follow: finite, rigid, continuous. A part that is
/// missing stays where it was on the palm; without the palm the whole hand stands still and, after a while, lets go. No allocation.
class HandTrackingMonitor
{
public:
	struct Target
	{
		ist::Pose X_WB;
		ist::Twist twist;  ///< of the target, from its last step
	};

	/// The hand begins in `start`, all of whose parts are known. The model outlives this.
	HandTrackingMonitor(const HandModel& model, const HandPartPoses& start, const HandTrackingLimits& limits = {});

	/// `dt` [s] positive.
	void update(const HandState& hand, double dt) noexcept;
	const Target& target(int part) const noexcept { return m_targets[static_cast<std::size_t>(part)]; }
	/// Share of the coupling's springs that is to act, 0 to 1.
	double grip() const noexcept { return m_grip; }
	const HandComplaints& complaints() const noexcept { return m_complaints; }

private:
	bool moveTowards(Target& target, const ist::Pose& X_WB, double dt) const noexcept;

	const HandModel& m_model;
	HandTrackingLimits m_limits;
	HandPartPoses m_last;  // those of missing parts carried along by the palm
	std::array<Target, kHandParts> m_targets;
	double m_grip = 1, m_lostFor = 0;
	HandComplaints m_complaints;
};

// Former names, until 0.4.
using HandWatch [[deprecated("since 0.3: HandTrackingMonitor")]] = HandTrackingMonitor;
using HandWatchLimits [[deprecated("since 0.3: HandTrackingLimits")]] = HandTrackingLimits;
}  // namespace devicebridge
