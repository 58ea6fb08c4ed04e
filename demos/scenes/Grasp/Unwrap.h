// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/TexturedMesh.h"

namespace scenes
{
/// What sticks out of a turned body, as that of a mug: a piece of a torus. Angles from -pi to pi [rad].
struct TurnedHandle
{
	bool (*has)(const ist::Vec3& p);
	double (*along)(const ist::Vec3& p);   ///< it
	double (*around)(const ist::Vec3& p);  ///< its middle line
};

/// Islands of a body turned about y: its outer and inner walls unrolled, what faces up and down seen along y, and its handle, where it has
/// one, unrolled. No two places of such a body share one in the picture, but where islands end.
ist::TexturedMesh unwrapTurned(const ist::Mesh& mesh, const TurnedHandle* handle = nullptr);
}  // namespace scenes
