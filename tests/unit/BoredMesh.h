// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

/// Half the outer size of a body with a bore.
struct Outside
{
	double size;            ///< radius, or half the side of a square [m]
	bool isSquare = false;  ///< otherwise round
};

/// A body from -halfLength to halfLength along z, with a round bore along z. Vertices of the bore are on its radius, `segments` around.
inline ist::Mesh boredMesh(double bore, const Outside& outside, double halfLength, uint32_t segments)
{
	ist::Mesh mesh;
	for (uint32_t i = 0; i < segments; ++i)
	{
		const double a = 2 * std::numbers::pi * i / segments, c = std::cos(a), s = std::sin(a);
		const double outer = outside.isSquare ? outside.size / std::max(std::fabs(c), std::fabs(s)) : outside.size;
		for (const double r : {outer, bore})
			for (const double z : {-halfLength, halfLength}) mesh.vertices.push_back({r * c, r * s, z});
	}
	const auto addQuad = [&mesh](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
		mesh.triangles.push_back({a, b, c});
		mesh.triangles.push_back({a, c, d});
	};
	for (uint32_t i = 0; i < segments; ++i)
	{
		const uint32_t p = 4 * i, q = 4 * ((i + 1) % segments);
		addQuad(p, q, q + 1, p + 1);          // outside
		addQuad(q + 2, p + 2, p + 3, q + 3);  // bore
		addQuad(p + 1, q + 1, q + 3, p + 3);  // top
		addQuad(q, p, p + 2, q + 2);          // bottom
	}
	return mesh;
}
