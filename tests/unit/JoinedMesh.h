// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstdint>

namespace ist
{
/// Two meshes as one, without common vertices.
inline Mesh joined(const Mesh& a, const Mesh& b)
{
	Mesh result = a;
	const auto first = static_cast<uint32_t>(a.vertices.size());
	result.vertices.insert(result.vertices.end(), b.vertices.begin(), b.vertices.end());
	for (const auto& t : b.triangles) result.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
	return result;
}
}  // namespace ist
