// SPDX-License-Identifier: Zlib
#pragma once

#include <cmath>

#include "BulletISTCollision/Core/Base/Pose.h"

namespace devicebridge
{
/// Keeps a gap between ticks from winding up the virtual coupling. While no tick runs, the hand goes on and the tool does not: taken
/// at face value, 22 ms at 0.1 m/s stretch a coupling of 4 kN/m by 9 N within one tick. So the way that the hand went in a gap is
/// taken off its pose and given back over `kReturn`: the coupling goes on as it was before the gap, and the tool follows.
class GapBridge
{
public:
	static constexpr double kShortest = 4;  ///< periods; a schedule that is merely slow is no gap
	static constexpr double kReturn = 0.1;  ///< time constant with which the hand gets back what was taken off [s]

	/// Pose of the hand that the tool shall follow, in W. `dt` [s] since the last call, which is a gap from kShortest periods on.
	ist::Pose reference(const ist::Pose& X_WH, double dt, double period) noexcept
	{
		if (dt > kShortest * period && m_hasLast)
		{
			m_shift = X_WH.translation - m_last.translation;
			m_turn = rotationVector(ist::quaternion(X_WH.rotation * transpose(m_last.rotation)));
		}
		const double kept = std::exp(-std::fmin(dt, period) / kReturn);
		m_shift *= kept;
		m_turn *= kept;
		m_last = {rotationMatrix(ist::quaternionFromRotationVector(-m_turn)) * X_WH.rotation, X_WH.translation - m_shift};
		m_hasLast = true;
		return m_last;
	}
	/// The hand may be anywhere.
	void forget() noexcept { *this = {}; }
	/// What is taken off at present [m].
	const ist::Vec3& shift() const noexcept { return m_shift; }

private:
	ist::Pose m_last;
	ist::Vec3 m_shift, m_turn;
	bool m_hasLast = false;
};
}  // namespace devicebridge
