// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "demos/scenes/HapticBunny/HapticBunny.h"

namespace scenes
{
/// Computes the sinkage of the body at rest in the pose X_WB. `volume` is the volume that must be under the plane: weight divided by the
/// pair's stiffness [m^3].
Sinkage judgeSinkage(const ist::InnerSphereTree& tree, const ist::Mesh& mesh, const ist::Pose& X_WB, double volume);

/// Compares volume and force at instants in contact with quadrature over the meshes. Both meshes are in the frames of the recorded poses.
void judgeTrace(
	const ist::Mesh& body, const ist::Mesh& probe, double bodyWeight, const HapticBunnyOptions& options, HapticBunnyOutcome& outcome);

/// Computes all figures that follow from the trace alone.
void summarise(HapticBunnyOutcome& outcome);
}  // namespace scenes
