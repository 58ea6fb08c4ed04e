// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "demos/scenes/HapticBunny/HapticBunny.h"

namespace scenes
{
/// `volume`: weight over stiffness of the pair, the volume that has to be under the plane [m^3]. X_WB: the body at rest.
Sinkage judgeSinkage(const ist::InnerSphereTree& tree, const ist::Mesh& mesh, const ist::Pose& X_WB, double volume);

/// Volume and force at instants in contact against quadrature over the meshes; both meshes in the frames of the recorded poses.
void judgeTrace(
	const ist::Mesh& body, const ist::Mesh& probe, double bodyWeight, const HapticBunnyOptions& options, HapticBunnyOutcome& outcome);

/// What follows from the trace alone.
void summarise(HapticBunnyOutcome& outcome);
}  // namespace scenes
