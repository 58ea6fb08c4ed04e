// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Safety/HeatBudget.h"

#include <algorithm>
#include <cmath>

#include "DeviceBridge/Safety/Saturation.h"

namespace devicebridge
{
HeatBudget::HeatBudget(double continuous, double peak, double timeConstant)
	: m_continuousSquared(continuous * continuous),
	  m_peakSquared(std::max(peak * peak, continuous * continuous)),
	  m_timeConstant(std::max(1e-3, timeConstant))
{}

bool HeatBudget::limit(ist::Vec3& v) const noexcept
{
	if (m_peakSquared <= m_continuousSquared) return false;
	const double left = std::clamp((1 - load()) / (1 - kKnee), 0.0, 1.0);
	return limitLength(v, std::sqrt(m_continuousSquared + left * (m_peakSquared - m_continuousSquared)));
}

void HeatBudget::spend(const ist::Vec3& v, double dt) noexcept
{
	m_meanSquare += (squaredNorm(v) - m_meanSquare) * -std::expm1(-std::max(0.0, dt) / m_timeConstant);
}

double HeatBudget::load() const noexcept { return m_continuousSquared > 0 ? m_meanSquare / m_continuousSquared : 1; }
}  // namespace devicebridge
