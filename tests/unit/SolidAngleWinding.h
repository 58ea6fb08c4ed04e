// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cmath>
#include <numbers>

/// Winding number by the solid angles of all triangles (van Oosterom and Strackee): an oracle without a hierarchy. O(triangles).
inline double windingNumber(const ist::Mesh& mesh, const ist::Vec3& p)
{
	double sum = 0;
	for (const auto& t : mesh.triangles)
	{
		const ist::Vec3 a = mesh.vertices[t[0]] - p, b = mesh.vertices[t[1]] - p, c = mesh.vertices[t[2]] - p;
		const double la = norm(a), lb = norm(b), lc = norm(c);
		sum += 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
	}
	return sum / (4 * std::numbers::pi);
}
