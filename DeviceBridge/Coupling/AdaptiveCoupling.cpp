// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Coupling/AdaptiveCoupling.h"

#include "BulletISTCollision/Core/Base/SymmetricEigen.h"

#include <algorithm>
#include <cmath>

namespace devicebridge
{
namespace
{
using Matrix6 = double[6][6];

/// The matrix [arm] with [arm] v = arm x v.
double crossMatrix(const ist::Vec3& arm, int i, int j)
{
	if (i == j) return 0;
	return ((j - i + 3) % 3 == 1 ? -1 : 1) * arm[3 - i - j];
}

/// Square of the stretch up to which a spring that saturates at `limit` is linear. Half of it is the derivative of the spring's energy by
/// its stiffness.
double stretchThatCounts(double stretch, double stiffness, double limit)
{
	const double counts = stiffness * stretch > limit ? limit / stiffness : stretch;
	return counts * counts;
}
}  // namespace

void addResistance(
	ist::SymmetricMatrix6& sum, const ist::SymmetricMatrix6& K, const ist::SymmetricMatrix6& D, const ist::Vec3& arm, double h) noexcept
{
	Matrix6 a, moved;
	for (int i = 0; i < 6; ++i)
		for (int j = 0; j < 6; ++j) a[i][j] = K(i, j) + 2 / h * D(i, j);
	// A rotation about the origin moves the point at `arm` by rotation x arm.
	for (int i = 0; i < 6; ++i)
		for (int j = 0; j < 6; ++j)
		{
			moved[i][j] = a[i][j];
			if (j < 3) continue;
			for (int k = 0; k < 3; ++k) moved[i][j] -= a[i][k] * crossMatrix(arm, k, j - 3);
		}
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j)
		{
			double value = moved[i][j];
			for (int k = 0; i >= 3 && k < 3; ++k) value -= crossMatrix(arm, k, i - 3) * moved[k][j];
			sum(i, j) += value;
		}
}

AdaptiveCoupling::AdaptiveCoupling(const CouplingGains& bounds) noexcept
	: m_bounds(bounds),
	  m_gains(bounds),
	  m_most(std::isfinite(bounds.softContact) ? std::max(1.0, bounds.softContact) : 1)
{
	m_factor = m_most;
	m_gains.stiffness *= m_factor;
	m_gains.angularStiffness *= m_factor;
}

/// The largest factor for which the series with the resistance stays within the bounds.
double AdaptiveCoupling::allowed(const ist::SymmetricMatrix6& resistance, double mass, double inertia, double h) const noexcept
{
	const double stiffness[2] = {m_bounds.stiffness, m_bounds.angularStiffness}, inert[2] = {4 * mass / (h * h), 4 * inertia / (h * h)};
	double unit[6], scaled[6][6];
	for (int i = 0; i < 6; ++i) unit[i] = stiffness[i / 3] > 0 ? 1 / std::sqrt(stiffness[i / 3]) : 0;
	for (int i = 0; i < 6; ++i)
		for (int j = 0; j < 6; ++j) scaled[i][j] = unit[i] * unit[j] * (resistance(i, j) + (i == j ? inert[i / 3] : 0));
	ist::SymmetricEigen<6> eigen;
	if (!eigen.decompose(scaled)) return 1;
	const double c = *std::max_element(eigen.values, eigen.values + 6);
	return c > 1 ? std::min(m_most, c / (c - 1)) : m_most;
}

void AdaptiveCoupling::adapt(const ist::SymmetricMatrix6& resistance, bool rigid, double mass, double inertia, const ist::Pose& X_WH,
	const ist::Pose& X_WT, double h) noexcept
{
	if (!adapts() || !(h > 0)) return;
	const double wanted = rigid ? 1 : allowed(resistance, mass, inertia, h);
	m_calm = wanted < m_factor ? 0 : m_calm + h;
	if (m_calm == 0) change(wanted, X_WH, X_WT);
	else if (m_calm > kHold) change(m_factor + (wanted - m_factor) * -std::expm1(-h / kRise), X_WH, X_WT);
	m_gains.stiffness = m_factor * m_bounds.stiffness;
	m_gains.angularStiffness = m_factor * m_bounds.angularStiffness;
}

/// A saturated spring holds f |x| - f^2 / 2 G, whose derivative by G is that of a spring stretched by f / G only. This is evaluated at the
/// old G. So it is an upper bound of the cost of stiffening, and a lower bound of the yield of softening.
void AdaptiveCoupling::change(double factor, const ist::Pose& X_WH, const ist::Pose& X_WT) noexcept
{
	const double way = distance(X_WH.translation, X_WT.translation);
	const double turn = norm(rotationVector(ist::quaternion(X_WH.rotation * transpose(X_WT.rotation))));
	const double perFactor = 0.5 *
		(m_bounds.stiffness * stretchThatCounts(way, m_gains.stiffness, m_bounds.maxForce) +
			m_bounds.angularStiffness * stretchThatCounts(turn, m_gains.angularStiffness, m_bounds.maxTorque));
	if (!std::isfinite(perFactor)) return;
	if (factor > m_factor && perFactor > 0) factor = std::min(factor, m_factor + m_tank / perFactor);
	m_tank = std::max(0.0, m_tank - (factor - m_factor) * perFactor);
	m_factor = factor;
	const auto most = [](double limit, double stiffness) { return stiffness > 0 ? limit * limit / (2 * stiffness) : 0; };
	const double room = most(m_bounds.maxForce, m_bounds.stiffness) + most(m_bounds.maxTorque, m_bounds.angularStiffness);
	m_tank = std::min(m_tank, std::isfinite(room) ? room : m_tank);
}
}  // namespace devicebridge
