// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/MeshDivision.h"

#include <algorithm>
#include <unordered_map>

namespace ist
{
namespace
{
/// The midpoints of the edges that are halved, each created once.
class Middles
{
public:
	Middles(Mesh& mesh, double longest) : m_mesh(mesh), m_longest(longest) {}

	/// Midpoint of the edge between two vertices; -1 if the edge is short enough.
	int64_t between(uint32_t a, uint32_t b)
	{
		const Vec3 p = m_mesh.vertices[a], q = m_mesh.vertices[b];
		if (!(distance(p, q) > m_longest)) return -1;
		const uint64_t key = uint64_t(std::min(a, b)) << 32 | std::max(a, b);
		const auto [at, fresh] = m_known.emplace(key, uint32_t(m_mesh.vertices.size()));
		if (fresh) m_mesh.vertices.push_back(0.5 * (p + q));
		return at->second;
	}

private:
	Mesh& m_mesh;
	double m_longest;
	std::unordered_map<uint64_t, uint32_t> m_known;
};

/// Appends the parts that replace a triangle `t`. The edges whose midpoints are given (edge i starts at corner i) are halved.
void divide(std::array<uint32_t, 3> t, std::array<int64_t, 3> middle, std::vector<std::array<uint32_t, 3>>& out)
{
	const int64_t halved = std::count_if(middle.begin(), middle.end(), [](int64_t m) { return m >= 0; });
	if (halved == 0) return out.push_back(t);
	// Rotates the triangle so that its first edge is halved; if two edges are halved, these are the first two.
	while (middle[0] < 0 || (halved == 2 && middle[1] < 0))
	{
		std::rotate(t.begin(), t.begin() + 1, t.end());
		std::rotate(middle.begin(), middle.begin() + 1, middle.end());
	}
	const auto m = [&](size_t i) { return uint32_t(middle[i]); };
	if (halved == 1)
	{
		out.push_back({t[0], m(0), t[2]});
		out.push_back({m(0), t[1], t[2]});
		return;
	}
	out.push_back({m(0), t[1], m(1)});
	if (halved == 2)
	{
		out.push_back({t[0], m(0), m(1)});
		out.push_back({t[0], m(1), t[2]});
		return;
	}
	out.push_back({t[0], m(0), m(2)});
	out.push_back({m(2), m(1), t[2]});
	out.push_back({m(0), m(1), m(2)});
}
}  // namespace

Mesh dividedMesh(const Mesh& mesh, double longest, size_t mostTriangles)
{
	Mesh now = mesh;
	// A round replaces each triangle by at most four.
	while (4 * now.triangles.size() <= mostTriangles)
	{
		Middles middles(now, longest);
		std::vector<std::array<uint32_t, 3>> parts;
		for (const auto& t : now.triangles)
			divide(t, {middles.between(t[0], t[1]), middles.between(t[1], t[2]), middles.between(t[2], t[0])}, parts);
		const bool done = parts.size() == now.triangles.size();
		now.triangles = std::move(parts);
		if (done) break;
	}
	return now;
}
}  // namespace ist
