// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Loop/ContactSource.h"

namespace devicebridge
{
struct CouplingGains
{
	double stiffness = 0, angularStiffness = 0;  ///< spring [N/m, N m/rad]
	double damping = 0, angularDamping = 0;      ///< damper [N s/m, N m s/rad]
	double maxForce = 0, maxTorque = 0;          ///< largest force and torque of the coupling [N, N m]
	/// Whether the coupling is static: the tool has no momentum. Each step puts the tool where coupling and contact balance, and the
	/// damping has no meaning. A degree of freedom without stiffness stays dynamic. Source: Wan and McNeely 2003.
	bool isStatic = false;
	/// Largest factor by which the coupling is stiffer while the contact is soft (AdaptiveCoupling.h); 1: never stiffer.
	double softContact = 1;
};

/// Mass of a tool that makes a coupling of stiffness K [N/m] static, or inertia for K [N m/rad]. The tool is at rest before the step and
/// pulled by staticPull(). Then the implicit step of a world with contact stiffness C is the Newton step (K + C) dx = K (x_h - x) +
/// F_contact.
inline double staticMass(double stiffness, double h) noexcept { return stiffness * h * h; }
/// Wrench K (x_h - x) on the tool at the beginning of the step, saturated, and likewise for rotation; about the origin of the tool, in W.
ist::Wrench staticPull(const CouplingGains& gains, const ist::Pose& X_WH, const ist::Pose& X_WT) noexcept;
/// Wrench of the coupling at the end of that step of `h` [s], after which the tool has the velocity `after`; saturated.
ist::Wrench staticWrench(const CouplingGains& gains, const ist::Wrench& pull, const ist::Twist& after, double h) noexcept;

/// A sentence that says why a coupling cannot move a tool with these inverses of mass and principal inertias; empty if it can. A static
/// coupling needs no mass. A dynamic one needs a finite mass for its stiffness and a finite inertia for its angular stiffness. Otherwise it
/// would pull for ever at a tool that never moves.
const char* whyNotCoupled(const CouplingGains& gains, double inverseMass, const ist::Vec3& inverseInertia) noexcept;

/// Wrench of spring and damper on the tool at the end of a step `h` [s], about the origin of the tool, in W. The velocity of the tool is
/// taken implicitly:
///   F = (K (x_h - x - h v) + B (v_h - v)) / (1 + (h B + h^2 K) / m)
/// Rotation is likewise, with the rotation vector of R_h R^T in W and a scalar inertia. Stable for all K, B and h. `mass` [kg] and
/// `inertia` [kg m^2] are positive; infinite ones give the explicit law.
ist::Wrench couplingOnTool(const CouplingGains& gains, const ist::Pose& X_WH, const ist::Twist& hand, const ToolState& tool, double mass,
	double inertia, double h) noexcept;

/// Gains that a device bears at sample time `h` [s]. The stiffness is at most the device's own limit and at most 2 (b - B) / h per Colgate
/// and Schenkel. `deviceDamping` b is the dissipation of the mechanism itself. Translation gets gains if at least one of its axes has an
/// actuator, and so does rotation; SafetyLimiter drops the force along the other axes. B is zero, because the damping of the coupling uses
/// up the margin that its stiffness needs.
CouplingGains passiveGains(const DeviceInfo& info, double deviceDamping, double deviceAngularDamping, double h) noexcept;
}  // namespace devicebridge
