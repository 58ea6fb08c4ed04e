// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "BulletISTCollision/Core/Mesh/MeshAxes.h"

#include <optional>
#include <string>
#include <string_view>

namespace ist
{
/// How ground, a surface without an inside such as terrain, becomes a body (RepairMode::Ground).
struct GroundClosing
{
	SignedAxis up;     ///< direction in which the ground faces; y by default
	double depth = 0;  ///< distance of the flat bottom below the lowest vertex [m], above 0
};

/// "ground 2 y": the depth in metres and the axis. Independent of the locale.
std::string groundText(const GroundClosing& ground);
/// Reads such a text, or "ground 2", whose axis is y. Empty optional for other texts and for depths that are not above 0.
std::optional<GroundClosing> groundFromText(std::string_view text);

/// Closes a surface downwards: open edges get vertical walls, and a flat copy of the surface is the bottom. Connected parts with open edges
/// are turned first if most of their area faces down. The result is whether they were turned. The volume is the integral of the height
/// above the bottom over the surface's projection where it faces up, less that where it faces down. Air under overhangs stays outside, and
/// holes become shafts. `mesh`: welded, oriented consistently. O(n log n). Errors: the depth is not a positive number, the axis is none, no
/// edge is open, the open parts do not face up, some face the other way, as ceilings do, or some lie over one another and would be filled
/// twice. After an error the mesh is unspecified.
Result<bool> closeDownwards(Mesh& mesh, const GroundClosing& ground);

/// The axis along which an open mesh faces one way nearly everywhere, as ground does; the other way round it may face down. The first of
/// y, z and x. Empty for other meshes.
std::optional<SignedAxis> facingOfGround(const Mesh& mesh);

/// The end of a refusal: names RepairMode::Ground if the mesh may be ground. Empty for others, also for open containers such as covers.
std::string groundAdvice(const Mesh& mesh);
}  // namespace ist
