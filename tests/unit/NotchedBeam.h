// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstdint>

/// A beam with a notch from above, its middle 0.06 m above the bottom of the notch. Convex parts that share faces would overlap there, so
/// it is one shell.
inline ist::Mesh notchedBeamMesh(double notch)
{
	const double a = notch / 2, L = .25, h = .06, z = .02;
	const double outline[8][2] = {{-L, -h}, {L, -h}, {L, h}, {a, h}, {a, 0}, {-a, 0}, {-a, h}, {-L, h}};
	const uint32_t quads[3][4] = {{0, 5, 6, 7}, {0, 1, 4, 5}, {1, 2, 3, 4}};  // counter-clockwise
	ist::Mesh mesh;
	for (const double side : {-z, z})
		for (const auto& p : outline) mesh.vertices.push_back({p[0], p[1], side});
	const auto triangle = [&](uint32_t a0, uint32_t b, uint32_t c) { mesh.triangles.push_back({a0, b, c}); };
	for (const auto& q : quads)
		for (int i = 1; i < 3; ++i)
		{
			triangle(q[0], q[i + 1], q[i]);
			triangle(8 + q[0], 8 + q[i], 8 + q[i + 1]);
		}
	for (uint32_t i = 0; i < 8; ++i)
	{
		const uint32_t j = (i + 1) % 8;
		triangle(i, j, 8 + j);
		triangle(i, 8 + j, 8 + i);
	}
	return mesh;
}
