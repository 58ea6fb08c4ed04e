// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "DeviceBridge/Coupling/VirtualCoupling.h"

namespace devicebridge
{
/// Adds what a patch resists with to `sum`. Stiffness K and damping D are about `arm` from the tool's origin, `sum` is about that origin,
/// the axes of all are the same. In steps of `h` [s] a motion to and fro meets K + 2 D / h (the difference of two samples is at most twice
/// their distance).
void addResistance(
	ist::SymmetricMatrix6& sum, const ist::SymmetricMatrix6& K, const ist::SymmetricMatrix6& D, const ist::Vec3& arm, double h) noexcept;

/// The stiffness of a virtual coupling, led by that of the contact, which grows with its area.
///
/// The hand feels coupling and contact in series, G - G (G + C)^-1 G. That never exceeds the coupling's G; so a coupling of what the device
/// bears, L = diag(K, K_a) (CouplingGains), is safe against everything and shows soft contact softer than it is. This one is G = g L with
/// the largest factor g whose series with the measured C stays within L in every direction of translation and rotation at once:
///   g = c / (c - 1) for c > 1, else unbounded,   c: the largest eigenvalue of L^-1/2 C L^-1/2;   never above `CouplingGains::softContact`.
/// So contact softer than the device bears is shown nearly as it is, and stiffer contact as what the device bears. What resists a motion to
/// and fro within two ticks counts as C: dampers by 2 D / h, the mass of a tool that has one by 4 M / h^2 (a heavy one gets no more than
/// L), friction as rigid, for it sticks.
///
/// A spring that stiffens while it is stretched makes energy, one that softens destroys it. Softening is immediate, since the bound must
/// hold (against the contacts that the source knows: BulletContactSource knows those of the tick before); what it destroys goes into a
/// tank. Stiffening takes kRise, begins kHold after it, and never costs more than the tank holds. Hence work done on the coupling's two
/// ends - stored in its spring - tank >= 0 at all times, whatever the contact does: the coupling is passive. At rest without a stretch
/// stiffening is free. O(1), no allocation.
class AdaptiveCoupling
{
public:
	static constexpr double kRise = 0.02;  ///< time constant of stiffening [s]
	static constexpr double kHold =
		0.01;  ///< that it waits for after each softening, so that a contact that chatters counts as one that lasts [s]

	explicit AdaptiveCoupling(const CouplingGains& bounds) noexcept;

	/// Whether adapt() has anything to do.
	bool adapts() const noexcept { return m_most > 1; }
	/// Before a step of `h` [s]. `resistance`: what the tool meets (addResistance), any axes; `rigid`: in contact that can stick. `mass`
	/// [kg] and `inertia` [kg m^2], the least, of a tool that has momentum; else 0. The poses are those at the beginning of the step.
	void adapt(const ist::SymmetricMatrix6& resistance, bool rigid, double mass, double inertia, const ist::Pose& X_WH,
		const ist::Pose& X_WT, double h) noexcept;
	/// With the stiffnesses of now.
	const CouplingGains& gains() const noexcept { return m_gains; }
	/// g.
	double factor() const noexcept { return m_factor; }
	/// [J]; at most what the spring holds when it saturates.
	double tank() const noexcept { return m_tank; }

private:
	double allowed(const ist::SymmetricMatrix6& resistance, double mass, double inertia, double h) const noexcept;
	void change(double factor, const ist::Pose& X_WH, const ist::Pose& X_WT) noexcept;

	CouplingGains m_bounds, m_gains;
	double m_most, m_factor = 1, m_tank = 0;
	double m_calm = 0;  // since the last softening [s]
};
}  // namespace devicebridge
