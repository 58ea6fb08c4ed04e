// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Force/PressureField.h"

namespace scenes
{
/// What the pressure field law puts in the way of a body that is pushed straight through another. Beyond the medial axis of a thin body
/// the force falls and changes its sign, so there is a largest one. A steady load passes through where it exceeds `force`, a free body of
/// mass m where its m v^2 / 2 exceeds `energy`. This is a property of material and thickness, whatever the step. Dissipation and friction
/// come on top. The force is that of PressureField.h.
struct PenetrationWork
{
	double force = 0;    ///< largest resistance on the way [N]
	double forceAt = 0;  ///< where the resistance is largest, from the start [m]
	double energy = 0;   ///< most work against the resistance, from the start up to any place of the way [J]
};

/// A moves by `way` [m] along `direction` (A's mesh frame, any length) without turning. It starts at the pose where B's mesh frame is
/// `X_AB` in its own. `steps` queries are asked; the thinnest body should take 20 of them. The function returns an error for what is not
/// finite, a way or number of steps that is not positive, a direction without length, and a tree that cannot be asked. It allocates nothing
/// beyond the workspace's own.
ist::Result<PenetrationWork> penetrationWork(const ist::InnerSphereTree& A, const ist::InnerSphereTree& B, const ist::Pose& X_AB,
	const ist::Vec3& direction, double way, const ist::PressurePair& pair, ist::QueryWorkspace& workspace, int steps = 400);
}  // namespace scenes
