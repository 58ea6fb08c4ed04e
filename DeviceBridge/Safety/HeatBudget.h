// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Vec3.h"

namespace devicebridge
{
/// I^2 t limit: motors heat with the square of the force. The mean of F^2, with exponential weight over `timeConstant`, never exceeds the
/// square of the continuous limit. Above `kKnee` of that square, the permitted force decreases from the peak to the continuous limit.
class HeatBudget
{
public:
	/// `continuous` and `peak` are in N or N m, `timeConstant` in s.
	HeatBudget(double continuous, double peak, double timeConstant);

	/// Shortens a vector to what the motors can bear now. Returns true if it did.
	bool limit(ist::Vec3& v) const noexcept;
	/// Records that the vector was exerted for `dt` [s].
	void spend(const ist::Vec3& v, double dt) noexcept;
	/// Mean square over the square of the continuous limit, 0 to 1.
	double load() const noexcept;

private:
	static constexpr double kKnee = 0.8;
	double m_continuousSquared, m_peakSquared, m_timeConstant;
	double m_meanSquare = 0;
};
}  // namespace devicebridge
