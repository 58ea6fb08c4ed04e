// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

namespace ist
{
/// Pose of B's tree frame in A's tree frame; X_AB is the pose of B's mesh frame in A's.
inline Pose treePose(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB)
{
	return {X_AB.rotation, X_AB.rotation * B.origin + (X_AB.translation - A.origin)};
}
}  // namespace ist
