// SPDX-License-Identifier: Zlib
#pragma once

#include <BulletCollision/CollisionShapes/btTriangleMesh.h>

#include <cmath>

/// A torus of 256 triangles about the y axis, lying.
inline btTriangleMesh* makeRing()
{
	const auto point = [](int i, int j) {
		const double u = i * 0.39269908169872414, v = j * 0.7853981633974483, r = 0.5 + 0.2 * std::cos(v);
		return btVector3(btScalar(r * std::cos(u)), btScalar(0.2 * std::sin(v)), btScalar(-r * std::sin(u)));
	};
	auto* mesh = new btTriangleMesh;
	for (int i = 0; i < 16; ++i)
		for (int j = 0; j < 8; ++j)
		{
			mesh->addTriangle(point(i, j), point(i + 1, j), point(i + 1, j + 1));
			mesh->addTriangle(point(i, j), point(i + 1, j + 1), point(i, j + 1));
		}
	return mesh;
}
