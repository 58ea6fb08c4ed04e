// SPDX-License-Identifier: Zlib
#pragma once

#include <algorithm>
#include <atomic>

#include "DeviceBridge/Loop/ContactSource.h"

namespace devicebridge
{
/// Lets a virtual coupling go and takes hold again. While it is off, the tool is free and the hand feels nothing. When it is on again, the
/// pull begins with pose and velocity of the tool, so without a force. It moves to the hand along a cubic Hermite curve, at `kSpeed` and
/// `kTurning` on average. The velocity that the tool had fades within `kShortest`, so that a long return does not begin with a detour.
class CouplingSwitch
{
public:
	static constexpr double kSpeed = 0.1, kTurning = 1;  ///< mean speed of the return [m/s, rad/s]
	static constexpr double kShortest = 0.3;             ///< shortest duration of the return [s]

	// For any thread:
	void set(bool on) noexcept { m_on.store(on, std::memory_order_relaxed); }
	bool isOn() const noexcept { return m_on.load(std::memory_order_relaxed); }

	// For the thread that ticks:
	/// Changes pose and twist of `hand` to those at which the coupling pulls the tool in a step of `dt` [s]. Returns false, and changes
	/// nothing, while the coupling is off. Call it once a tick.
	bool lead(DeviceState& hand, const ToolState& tool, double dt) noexcept
	{
		if (!isOn()) return m_was = false;
		if (!isRigid(hand.X_WH) || !isFinite(hand.twist)) return true;
		if (!m_was) begin(hand, tool, dt);
		m_was = true;
		if (m_time >= m_duration) return true;
		const double u = m_time / m_duration, w = (std::min)(1.0, m_time / kShortest);
		// Hermite basis of the offset and of its velocity at time 0, and the derivatives of both.
		const double a = 1 + u * u * (2 * u - 3), b = kShortest * w * (1 - w) * (1 - w);
		const double da = 6 * u * (u - 1) / m_duration, db = (1 - w) * (1 - 3 * w);
		hand.X_WH.translation += a * m_offset + b * m_velocity;
		hand.X_WH.rotation = rotationMatrix(ist::quaternionFromRotationVector(a * m_turn + b * m_spin)) * hand.X_WH.rotation;
		hand.twist.linear += da * m_offset + db * m_velocity;
		hand.twist.angular += da * m_turn + db * m_spin;
		m_time += dt;
		return true;
	}

private:
	void begin(const DeviceState& hand, const ToolState& tool, double dt) noexcept
	{
		m_offset = tool.X_WT.translation - hand.X_WH.translation;
		m_turn = rotationVector(ist::quaternion(tool.X_WT.rotation * transpose(hand.X_WH.rotation)));
		m_velocity = tool.twist.linear - hand.twist.linear;
		m_spin = tool.twist.angular - hand.twist.angular;
		m_duration = (std::max)({kShortest, norm(m_offset) / kSpeed, norm(m_turn) / kTurning});
		m_time = dt;  // the coupling leads a moving tool by one step
	}

	std::atomic<bool> m_on{true};
	bool m_was = true;                               // the coupling was on in the last tick, with a usable hand
	ist::Vec3 m_offset, m_turn, m_velocity, m_spin;  // of the tool relative to the hand when the coupling took hold again, in W
	double m_time = 0, m_duration = 0;               // time since then, and duration of the return [s]
};
}  // namespace devicebridge
