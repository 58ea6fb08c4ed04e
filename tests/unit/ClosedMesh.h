// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <map>
#include <utility>

/// Each edge is walked once in each direction.
inline bool isClosed(const ist::Mesh& mesh)
{
	std::map<std::pair<uint32_t, uint32_t>, int> edges;
	for (const auto& t : mesh.triangles)
		for (size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
	for (const auto& [edge, count] : edges)
		if (count != 1 || !edges.count({edge.second, edge.first})) return false;
	return true;
}
