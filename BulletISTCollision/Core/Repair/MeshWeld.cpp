// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshWeld.h"

#include "BulletISTCollision/Core/Mesh/MeshEdges.h"

#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <unordered_map>
#include <vector>

namespace ist
{
namespace
{
struct IntegerTripleHash
{
	std::size_t operator()(const std::array<int64_t, 3>& key) const
	{
		uint64_t h = 0;
		for (const int64_t k : key)
		{
			h = (h ^ static_cast<uint64_t>(k)) * 0x9e3779b97f4a7c15ull;
			h ^= h >> 29;
		}
		return static_cast<std::size_t>(h);
	}
};
template <class T> using IntegerTripleMap = std::unordered_map<std::array<int64_t, 3>, T, IntegerTripleHash>;

/// Bit patterns of the coordinates, with -0 taken as 0.
std::array<int64_t, 3> exactKey(const Vec3& v)
{
	std::array<int64_t, 3> key{};
	for (int axis = 0; axis < 3; ++axis)
	{
		const double value = v[axis] + 0.0;
		std::memcpy(&key[static_cast<std::size_t>(axis)], &value, sizeof value);
	}
	return key;
}

/// `target[i]` is the vertex that replaces vertex i; vertices that no triangle uses are dropped.
Mesh renumbered(const Mesh& mesh, const std::vector<uint32_t>& target)
{
	Mesh result;
	result.rounding = mesh.rounding;
	std::vector<uint8_t> used(mesh.vertices.size(), 0);
	for (const Triangle& t : mesh.triangles)
		for (const uint32_t corner : t) used[target[corner]] = 1;
	std::vector<uint32_t> number(mesh.vertices.size(), 0);
	for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
		if (used[i])
		{
			number[i] = static_cast<uint32_t>(result.vertices.size());
			result.vertices.push_back(mesh.vertices[i]);
		}
	result.triangles.reserve(mesh.triangles.size());
	for (const Triangle& t : mesh.triangles) result.triangles.push_back({number[target[t[0]]], number[target[t[1]]], number[target[t[2]]]});
	return result;
}

/// Upper bound of the volume that the triangles sweep when their corners move to their targets [m^3].
double sweptVolume(const Mesh& mesh, const std::vector<uint32_t>& target)
{
	double volume = 0;
	for (const Triangle& t : mesh.triangles)
	{
		double way = 0;
		for (const uint32_t corner : t) way += distance(mesh.vertices[corner], mesh.vertices[target[corner]]);
		if (way == 0) continue;
		const Vec3& a = mesh.vertices[t[0]];
		volume += way / 3 * 0.5 * norm(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a));
	}
	return volume;
}
}  // namespace

Mesh withoutUnusedVertices(const Mesh& mesh)
{
	std::vector<uint32_t> identity(mesh.vertices.size());
	std::iota(identity.begin(), identity.end(), 0u);
	return renumbered(mesh, identity);
}

Mesh weldedEqual(const Mesh& mesh)
{
	IntegerTripleMap<uint32_t> firstAt;
	firstAt.reserve(mesh.vertices.size());
	std::vector<uint32_t> target(mesh.vertices.size());
	for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
		target[i] = firstAt.try_emplace(exactKey(mesh.vertices[i]), static_cast<uint32_t>(i)).first->second;
	return renumbered(mesh, target);
}

std::vector<uint32_t> verticesOfOpenEdges(const Mesh& mesh)
{
	std::vector<uint8_t> isOpen(mesh.vertices.size(), 0);
	forEachEdge(sortedEdges(mesh), [&](const EdgeUse* use, std::size_t count) {
		if (count == 1) isOpen[use->low] = isOpen[use->high] = 1;
	});
	std::vector<uint32_t> open;
	for (uint32_t i = 0; i < isOpen.size(); ++i)
		if (isOpen[i]) open.push_back(i);
	return open;
}

WeldedVertices weldNear(Mesh& mesh, const std::vector<uint32_t>& vertices, double tolerance)
{
	const Vec3 origin = bounds(mesh).lower;
	const auto cellOf = [&](const Vec3& v, int axis) { return static_cast<int64_t>(std::floor((v[axis] - origin[axis]) / tolerance)); };
	IntegerTripleMap<std::vector<uint32_t>> grid;
	std::vector<uint32_t> target(mesh.vertices.size());
	std::iota(target.begin(), target.end(), 0u);
	WeldedVertices welded;
	for (const uint32_t i : vertices)
	{
		const Vec3& v = mesh.vertices[i];
		const std::array<int64_t, 3> cell{cellOf(v, 0), cellOf(v, 1), cellOf(v, 2)};
		for (int k = 0; k < 27 && target[i] == i; ++k)
		{
			const auto entry = grid.find({cell[0] + k % 3 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k / 9 - 1});
			if (entry == grid.end()) continue;
			for (const uint32_t other : entry->second)
				if (distance(mesh.vertices[other], v) <= tolerance) target[i] = other;
		}
		if (target[i] == i) grid[cell].push_back(i);
		else ++welded.count;
	}
	if (welded.count == 0) return welded;
	welded.doubt = sweptVolume(mesh, target);
	mesh = renumbered(mesh, target);
	return welded;
}
}  // namespace ist
