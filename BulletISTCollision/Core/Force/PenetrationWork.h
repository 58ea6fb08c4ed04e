// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Force/PressureField.h"

namespace ist
{
/// What the pressure field law puts in the way of a body that is pushed straight through another. Beyond the medial axis of a thin body
/// the force falls and turns over, so there is a largest one: a steady load passes through where it exceeds `force`, a free body of mass m
/// where its m v^2 / 2 exceeds `energy`. This is a property of material and thickness, whatever the step. Dissipation and
/// friction come on top. The force is that of PressureField.h.
struct PenetrationWork
{
	double force = 0;    ///< largest resistance on the way [N]
	double forceAt = 0;  ///< where, from the start [m]
	double energy = 0;   ///< most work against it from the start up to any place of the way [J]
};

/// A at the pose where B's mesh frame is `X_AB` in its own, moved by `way` [m] along `direction` (A's mesh frame, any length) without
/// turning. `steps` queries; the thinnest body should take 20 of them. An error for what is not finite, a way or number of steps that is
/// not positive, a direction without length, a tree that cannot be asked. Offline, but allocates nothing beyond the workspace's own.
Result<PenetrationWork> passageBarrier(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, const Vec3& direction,
	double way, const PressurePair& pair, QueryWorkspace& workspace, int steps = 400);
}  // namespace ist
