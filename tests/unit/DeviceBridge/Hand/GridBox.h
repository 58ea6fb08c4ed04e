// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/TexturedMesh.h"

#include <map>
#include <utility>

/// A box whose sides are grids of n by n squares with shared corners. The sides lie next to each other in the picture, three in a row. Each
/// has a frame of `frame` times its width.
inline ist::TexturedMesh texturedGridBox(const ist::Vec3& half, int n, double frame = 0.1)
{
	ist::TexturedMesh box;
	std::map<std::array<int, 3>, uint32_t> index;
	const auto vertex = [&](std::array<int, 3> c) {
		const auto [at, fresh] = index.emplace(c, uint32_t(box.mesh.vertices.size()));
		if (fresh)
			box.mesh.vertices.push_back({half.x * (2.0 * c[0] / n - 1), half.y * (2.0 * c[1] / n - 1), half.z * (2.0 * c[2] / n - 1)});
		return at->second;
	};
	for (int a = 0; a < 3; ++a)
		for (const int side : {0, n})
			for (int i = 0; i < n; ++i)
				for (int j = 0; j < n; ++j)
				{
					const auto corner = [&](int u, int v) {
						std::array<int, 3> c{};
						c[size_t(a)] = side, c[size_t((a + 1) % 3)] = i + u, c[size_t((a + 2) % 3)] = j + v;
						return vertex(c);
					};
					const auto place = [&](int u, int v) {
						return ist::TexturePlace{
							(a + frame + (1 - 2 * frame) * (i + u) / n) / 3, ((side > 0) + frame + (1 - 2 * frame) * (j + v) / n) / 2};
					};
					std::array<uint32_t, 4> q{corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
					std::array<ist::TexturePlace, 4> p{place(0, 0), place(1, 0), place(1, 1), place(0, 1)};
					if (side == 0) std::swap(q[1], q[3]), std::swap(p[1], p[3]);
					box.mesh.triangles.push_back({q[0], q[1], q[2]});
					box.mesh.triangles.push_back({q[0], q[2], q[3]});
					box.places.push_back({p[0], p[1], p[2]});
					box.places.push_back({p[0], p[2], p[3]});
				}
	return box;
}

inline ist::Mesh gridBox(const ist::Vec3& half, int n) { return texturedGridBox(half, n).mesh; }
