// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/TexturedMesh.h"

namespace scenes
{
/// The handle of a turned body such as a mug: a part of a torus. Angles are from -pi to pi [rad].
struct TurnedHandle
{
	bool (*has)(const ist::Vec3& p);
	double (*along)(const ist::Vec3& p);   ///< angle along the handle
	double (*around)(const ist::Vec3& p);  ///< angle around the handle's middle line
};

/// Texture islands of a body turned about y. Its outer and inner walls are unrolled. Surfaces that face up or down are projected along y.
/// A handle, if there is one, is unrolled too. Two places of such a body share a place in the picture only at the borders of islands.
ist::TexturedMesh unwrapTurned(const ist::Mesh& mesh, const TurnedHandle* handle = nullptr);
}  // namespace scenes
