// SPDX-License-Identifier: Zlib
#pragma once

#include <cmath>

#include "BulletISTCollision/Core/Base/Pose.h"

namespace devicebridge
{
/// Keeps a gap between ticks from stretching the virtual coupling. While no tick runs, the hand moves on but the tool does not. Without
/// correction, 22 ms at 0.1 m/s stretch a coupling of 4 kN/m by 9 N within one tick. So the hand's displacement during a gap is subtracted
/// from its pose, and this offset decays with `kReturn`. The coupling continues as before the gap, and the tool follows.
class GapBridge
{
public:
	static constexpr double kShortest = 4;  ///< shortest gap [periods]; a schedule that is only slow is no gap
	static constexpr double kReturn = 0.1;  ///< time constant with which the offset decays [s]

	/// Pose of the hand that the tool follows, in W. `dt` is the time since the last call [s], which counts as a gap above kShortest
	/// periods.
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
	/// Accepts any next pose of the hand without a gap.
	void forget() noexcept { *this = {}; }
	/// Present offset that is subtracted from the hand's position [m].
	const ist::Vec3& shift() const noexcept { return m_shift; }

private:
	ist::Pose m_last;
	ist::Vec3 m_shift, m_turn;
	bool m_hasLast = false;
};
}  // namespace devicebridge
