// SPDX-License-Identifier: Zlib
#include "demos/scenes/Bodies/ImplicitMesh.h"

#include <cmath>

using namespace ist;

namespace scenes
{
namespace
{
using Field = std::function<double(const Vec3&)>;
constexpr uint32_t kNone = 0xffffffffu;

struct Grid
{
	Vec3 lower;
	double cell;
	size_t n[3];
	std::vector<double> values;

	Grid(const Field& field, const Box& box, double size) : lower(box.lower), cell(size)
	{
		for (int a = 0; a < 3; ++a) n[a] = static_cast<size_t>(std::ceil(box.size()[a] / size)) + 1;
		values.resize(n[0] * n[1] * n[2]);
		for (size_t z = 0; z < n[2]; ++z)
			for (size_t y = 0; y < n[1]; ++y)
				for (size_t x = 0; x < n[0]; ++x) values[index(x, y, z)] = field(place(x, y, z));
	}
	size_t index(size_t x, size_t y, size_t z) const { return (z * n[1] + y) * n[0] + x; }
	Vec3 place(size_t x, size_t y, size_t z) const { return lower + cell * Vec3{double(x), double(y), double(z)}; }
};

/// Mean of the points where the surface crosses the cell's edges. Returns false when it crosses none.
bool crossing(const Grid& g, size_t x, size_t y, size_t z, Vec3& mean)
{
	double values[8];
	Vec3 corners[8];
	for (size_t i = 0; i < 8; ++i)
	{
		const size_t cx = x + (i & 1), cy = y + (i >> 1 & 1), cz = z + (i >> 2);
		values[i] = g.values[g.index(cx, cy, cz)];
		corners[i] = g.place(cx, cy, cz);
	}
	int count = 0;
	mean = {};
	for (size_t i = 0; i < 8; ++i)
		for (size_t bit = 1; bit < 8; bit <<= 1)
		{
			const size_t j = i | bit;
			if (i == j || (values[i] > 0) == (values[j] > 0)) continue;
			mean += corners[i] + values[i] / (values[i] - values[j]) * (corners[j] - corners[i]);
			++count;
		}
	if (count > 0) mean = mean / double(count);
	return count > 0;
}

/// Makes Newton steps along the gradient, limited to the cell's size around the start.
Vec3 ontoSurface(const Field& field, const Vec3& start, double cell)
{
	Vec3 p = start;
	const double e = 1e-3 * cell;
	for (int i = 0; i < 2; ++i)
	{
		const Vec3 g = Vec3{field(p + Vec3{e, 0, 0}) - field(p - Vec3{e, 0, 0}), field(p + Vec3{0, e, 0}) - field(p - Vec3{0, e, 0}),
						   field(p + Vec3{0, 0, e}) - field(p - Vec3{0, 0, e})} /
			(2 * e);
		if (!(squaredNorm(g) > 0.01)) break;
		p = p - field(p) / squaredNorm(g) * g;
	}
	return distance(p, start) < 0.5 * cell ? p : start;
}
}  // namespace

Mesh meshOfField(const Field& field, const Box& box, double cell)
{
	const Grid g(field, box, cell);
	Mesh mesh;
	std::vector<uint32_t> vertexOf(g.values.size(), kNone);
	for (size_t z = 0; z + 1 < g.n[2]; ++z)
		for (size_t y = 0; y + 1 < g.n[1]; ++y)
			for (size_t x = 0; x + 1 < g.n[0]; ++x)
			{
				Vec3 mean;
				if (!crossing(g, x, y, z, mean)) continue;
				vertexOf[g.index(x, y, z)] = static_cast<uint32_t>(mesh.vertices.size());
				mesh.vertices.push_back(ontoSurface(field, mean, cell));
			}
	// Each edge of the grid that the surface crosses gets a face between the four cells around it.
	const size_t step[3] = {1, g.n[0], g.n[0] * g.n[1]};
	for (size_t z = 1; z + 1 < g.n[2]; ++z)
		for (size_t y = 1; y + 1 < g.n[1]; ++y)
			for (size_t x = 1; x + 1 < g.n[0]; ++x)
				for (int a = 0; a < 3; ++a)
				{
					const size_t at = g.index(x, y, z), u = step[(a + 1) % 3], v = step[(a + 2) % 3];
					const bool inside = g.values[at] > 0;
					if (inside == (g.values[at + step[a]] > 0)) continue;
					uint32_t q[4] = {vertexOf[at - u - v], vertexOf[at - v], vertexOf[at], vertexOf[at - u]};
					if (!inside) std::swap(q[1], q[3]);
					mesh.triangles.push_back({q[0], q[1], q[2]});
					mesh.triangles.push_back({q[0], q[2], q[3]});
				}
	return mesh;
}
}  // namespace scenes
