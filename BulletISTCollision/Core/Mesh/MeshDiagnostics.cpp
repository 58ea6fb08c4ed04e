// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/MeshDiagnostics.h"

#include <charconv>
#include <cstddef>

namespace ist
{
std::string number(double value)
{
	char text[32];
	return std::string(text, std::to_chars(text, text + sizeof text, value, std::chars_format::general, 6).ptr);
}

std::string place(const Vec3& p) { return "(" + number(p.x) + ", " + number(p.y) + ", " + number(p.z) + ") m"; }

std::string extent(const Box& box) { return "between " + place(box.lower) + " and " + place(box.upper); }

std::string whereNotFinite(const Mesh& mesh)
{
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
		for (const uint32_t corner : mesh.triangles[i])
		{
			if (isFinite(mesh.vertices[corner])) continue;
			std::string found = "the coordinates of a corner of triangle " + std::to_string(i) +
				" are not finite: " + place(mesh.vertices[corner]);
			for (const uint32_t other : mesh.triangles[i])
				if (isFinite(mesh.vertices[other])) return found + ", beside " + place(mesh.vertices[other]);
			return found;
		}
	for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
		if (!isFinite(mesh.vertices[i]))
			return "the coordinates of vertex " + std::to_string(i) +
				", which no triangle uses, are not finite: " + place(mesh.vertices[i]);
	return {};
}
}  // namespace ist
