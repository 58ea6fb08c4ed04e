// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "DeviceBridge/Coupling/VirtualCoupling.h"

namespace devicebridge
{
/// Adds the resistance of a patch to `sum`. Stiffness K and damping D are about the point `arm` from the tool's origin, `sum` is about that
/// origin, and all have the same axes. In steps of `h` [s] an oscillation meets K + 2 D / h, because the difference of two samples is at
/// most twice their amplitude.
void addResistance(
	ist::SymmetricMatrix6& sum, const ist::SymmetricMatrix6& K, const ist::SymmetricMatrix6& D, const ist::Vec3& arm, double h) noexcept;

/// The stiffness of a virtual coupling, adapted to the stiffness of the contact, which grows with its area.
///
/// The hand feels coupling and contact in series, G - G (G + C)^-1 G, which never exceeds the coupling's G. So a coupling of what the
/// device bears, L = diag(K, K_a) (CouplingGains), is safe with every contact, but a soft contact feels softer than it is. This class uses
/// G = g L. The factor g is the largest for which the series with the measured C stays within L, in every direction of translation and
/// rotation:
///   g = c / (c - 1) for c > 1, else unbounded,   c: the largest eigenvalue of L^-1/2 C L^-1/2;   never above `CouplingGains::softContact`.
/// So a contact softer than the device bears is shown with nearly its own stiffness, and a stiffer contact with what the device bears.
/// Everything that resists an oscillation with a period of two ticks counts as C. Dampers count as 2 D / h, and the mass of a tool that has
/// one as 4 M / h^2, so a heavy tool gets only L. Friction counts as rigid, because it sticks.
///
/// A spring that stiffens while it is stretched generates energy; one that softens destroys energy. Softening is immediate, because the
/// bound must hold for the known contacts (BulletContactSource knows those of the previous tick). The energy that it destroys goes into an
/// energy tank. Stiffening has the time constant kRise, begins kHold after the last softening, and never costs more than the tank holds.
/// Therefore work done on the coupling's two ends - energy in its spring - tank >= 0 at all times, for any contact: the coupling is
/// passive. At rest without a stretch stiffening is free. O(1), no allocation.
class AdaptiveCoupling
{
public:
	static constexpr double kRise = 0.02;  ///< time constant of stiffening [s]
	static constexpr double kHold =
		0.01;  ///< wait of stiffening after each softening [s], so that a chattering contact counts as a lasting one

	explicit AdaptiveCoupling(const CouplingGains& bounds) noexcept;

	/// Whether adapt() has any effect.
	bool adapts() const noexcept { return m_most > 1; }
	/// Adapts the stiffness before a step of `h` [s]. `resistance` is the sum of what the tool meets (addResistance), in any axes. `rigid`:
	/// the contact can stick. `mass` [kg] and the least `inertia` [kg m^2] are those of a tool that has momentum; else 0. The poses are
	/// those at the beginning of the step.
	void adapt(const ist::SymmetricMatrix6& resistance, bool rigid, double mass, double inertia, const ist::Pose& X_WH,
		const ist::Pose& X_WT, double h) noexcept;
	/// The gains with the present stiffnesses.
	const CouplingGains& gains() const noexcept { return m_gains; }
	/// The present factor g.
	double factor() const noexcept { return m_factor; }
	/// Energy in the tank [J]; at most what the spring holds when it saturates.
	double tank() const noexcept { return m_tank; }

private:
	double allowed(const ist::SymmetricMatrix6& resistance, double mass, double inertia, double h) const noexcept;
	void change(double factor, const ist::Pose& X_WH, const ist::Pose& X_WT) noexcept;

	CouplingGains m_bounds, m_gains;
	double m_most, m_factor = 1, m_tank = 0;
	double m_calm = 0;  // time since the last softening [s]
};
}  // namespace devicebridge
