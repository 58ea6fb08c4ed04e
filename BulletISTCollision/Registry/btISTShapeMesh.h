// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

class btCollisionShape;

/// The triangles of a shape in its own frame [m], as they are now: local scaling included, collision margin left out. Of GImpact meshes
/// and of triangle meshes their triangles, of convex hulls and convex triangle meshes those of the hull, of btMultiSphereShape those of a
/// hull that lies inside of it, by .4 % of a radius at most. O(triangles).
///
/// Refused: terrain and planes (surfaces without an inside), shapes that are known in closed form (they meet trees without one),
/// compounds (the children of a btCompoundShape are shapes of their own), soft bodies, vertices that are not finite.
ist::Result<ist::Mesh> meshOfShape(const btCollisionShape& shape);
