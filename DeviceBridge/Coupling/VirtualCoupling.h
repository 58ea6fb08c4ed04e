// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Loop/ContactSource.h"

namespace devicebridge
{
struct CouplingGains
{
	double stiffness = 0, angularStiffness = 0;  ///< [N/m, N m/rad]
	double damping = 0, angularDamping = 0;      ///< [N s/m, N m s/rad]
	double maxForce = 0, maxTorque = 0;          ///< [N, N m]
	/// The static coupling: the tool has no momentum, each step puts it where coupling and contact balance, and the damping has no meaning.
	/// A freedom without stiffness stays dynamic. Source: Wan and McNeely 2003.
	bool isStatic = false;
	/// As long as contact is soft, up to so many times stiffer (AdaptiveCoupling.h); 1: never.
	double softContact = 1;
};

/// Mass of a tool that stands for a static coupling of stiffness K [N/m], or inertia for one of K [N m/rad]: at rest before the step, and
/// pulled by staticPull(), the implicit step of a world with contact stiffness C is the Newton step (K + C) dx = K (x_h - x) + F_contact.
inline double staticMass(double stiffness, double h) noexcept { return stiffness * h * h; }
/// K (x_h - x) on the tool at the beginning of the step, and likewise for rotation, saturated; about the origin of the tool, in W.
ist::Wrench staticPull(const CouplingGains& gains, const ist::Pose& X_WH, const ist::Pose& X_WT) noexcept;
/// What the coupling exerts at the end of that step of `h` [s], after which the tool has the velocity `after`; saturated.
ist::Wrench staticWrench(const CouplingGains& gains, const ist::Wrench& pull, const ist::Twist& after, double h) noexcept;

/// Why a coupling cannot lead a tool with these inverses of mass and principal inertias, in a sentence. Empty when it can.
/// A static coupling needs no mass. A dynamic one needs a finite mass, or inertia, for what it pulls.
/// Otherwise it would pull for ever at a tool that never moves.
const char* whyNotCoupled(const CouplingGains& gains, double inverseMass, const ist::Vec3& inverseInertia) noexcept;

/// Wrench of the spring and damper on the tool at the end of a step `h` [s], the velocity of the tool taken implicitly,
/// about the origin of the tool, in W:
///   F = (K (x_h - x - h v) + B (v_h - v)) / (1 + (h B + h^2 K) / m)
/// and likewise for rotation with the rotation vector of R_h R^T in W and a scalar inertia. Stable for all K, B and h.
/// `mass` [kg] and `inertia` [kg m^2] are positive; infinite ones give the explicit law.
ist::Wrench couplingOnTool(const CouplingGains& gains, const ist::Pose& X_WH, const ist::Twist& hand, const ToolState& tool, double mass,
	double inertia, double h) noexcept;

/// Gains that a device bears at sample time `h` [s]: at most its own largest stiffness and 2 (b - B) / h per
/// Colgate and Schenkel, where `deviceDamping` b is what the mechanism itself dissipates; no gain where it lacks an
/// actuator. B is zero: the damping of the coupling spends the margin that its stiffness needs.
CouplingGains passiveGains(const DeviceInfo& info, double deviceDamping, double deviceAngularDamping, double h) noexcept;
}  // namespace devicebridge
