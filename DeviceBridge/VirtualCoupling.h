// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/ContactSource.h"

namespace devicebridge
{
struct CouplingGains
{
	double stiffness = 0, angularStiffness = 0;  ///< [N/m, N m/rad]
	double damping = 0, angularDamping = 0;      ///< [N s/m, N m s/rad]
	double maxForce = 0, maxTorque = 0;          ///< [N, N m]
};

/// Wrench of the spring and damper on the tool at the end of a step `h` [s], the velocity of the tool taken implicitly,
/// about the origin of the tool, in W:
///   F = (K (x_h - x - h v) + B (v_h - v)) / (1 + (h B + h^2 K) / m)
/// and likewise for rotation with the rotation vector of R_h R^T in W and a scalar inertia. Stable for all K, B and h.
/// `mass` [kg] and `inertia` [kg m^2] are positive; infinite ones give the explicit law.
ist::Wrench couplingOnTool(const CouplingGains& gains, const ist::Pose& X_WH, const ist::Twist& hand,
						   const ToolState& tool, double mass, double inertia, double h) noexcept;

/// Gains that a device bears at sample time `h` [s]: at most its own largest stiffness and 2 (b - B) / h per
/// Colgate and Schenkel, where `deviceDamping` b is what the mechanism itself dissipates; no gain where it lacks an
/// actuator. B is zero: the damping of the coupling spends the margin that its stiffness needs.
CouplingGains passiveGains(const DeviceInfo& info, double deviceDamping, double deviceAngularDamping, double h) noexcept;
}  // namespace devicebridge
