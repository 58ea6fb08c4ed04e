// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/MeshShells.h"

#include "BulletISTCollision/Core/MeshEdges.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace ist
{
namespace
{
constexpr std::size_t kNestingProbes = 16;

/// One closed component.
struct Shell
{
	std::vector<uint32_t> triangles;
	Box box;
	double volume = 0;  ///< signed
};

std::vector<Shell> shells(const Mesh& mesh)
{
	const std::vector<uint32_t> component = componentOfTriangle(mesh, sortedEdges(mesh));
	std::vector<Shell> result;
	std::vector<uint32_t> shellOf(mesh.triangles.size());
	for (uint32_t i = 0; i < mesh.triangles.size(); ++i)
	{
		if (component[i] == i)
		{
			shellOf[i] = static_cast<uint32_t>(result.size());
			const Vec3& v = mesh.vertices[mesh.triangles[i][0]];
			result.push_back({{}, {v, v}, 0});
		}
		Shell& shell = result[shellOf[component[i]]];
		shell.triangles.push_back(i);
		const Triangle& t = mesh.triangles[i];
		for (const uint32_t corner : t)
		{
			shell.box.lower = componentMin(shell.box.lower, mesh.vertices[corner]);
			shell.box.upper = componentMax(shell.box.upper, mesh.vertices[corner]);
		}
		const Vec3 origin = mesh.vertices[mesh.triangles[shell.triangles[0]][0]];
		shell.volume += dot(mesh.vertices[t[0]] - origin,
							cross(mesh.vertices[t[1]] - origin, mesh.vertices[t[2]] - origin)) / 6;
	}
	return result;
}

/// True where the half-line from p towards +x crosses the edge, seen along z. Both triangles of an edge get the same answer.
bool crossesEdge(const Vec3& p, const Vec3& a, const Vec3& b)
{
	if ((a.y > p.y) == (b.y > p.y)) return false;
	const Vec3 &lower = a.y < b.y ? a : b, &upper = a.y < b.y ? b : a;
	return p.x < lower.x + (p.y - lower.y) / (upper.y - lower.y) * (upper.x - lower.x);
}

/// Parity of the triangles above p: however the shell is turned, and without solid angles, which cost twenty times as much.
bool encloses(const Mesh& mesh, const Shell& shell, const Vec3& p)
{
	bool inside = false;
	for (const uint32_t i : shell.triangles)
	{
		const Triangle& t = mesh.triangles[i];
		const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
		if ((crossesEdge(p, a, b) != crossesEdge(p, b, c)) == crossesEdge(p, c, a)) continue;
		const Vec3 n = cross(b - a, c - a);
		const double height = n.z != 0 ? -dot(n, p - a) * (n.z > 0 ? -1 : 1) : p.z - (a.z + b.z + c.z) / 3;
		if (height < 0) inside = !inside;
	}
	return inside;
}

/// Every probe must lie inside: shells that merely cut each other are not nested.
bool encloses(const Mesh& mesh, const Shell& outer, const Shell& inner)
{
	for (int axis = 0; axis < 3; ++axis)
		if (inner.box.lower[axis] < outer.box.lower[axis] || inner.box.upper[axis] > outer.box.upper[axis]) return false;
	const std::size_t stride = std::max<std::size_t>(1, inner.triangles.size() / kNestingProbes);
	for (std::size_t i = 0; i < inner.triangles.size(); i += stride)
	{
		const Triangle& t = mesh.triangles[inner.triangles[i]];
		if (!encloses(mesh, outer, (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3)) return false;
	}
	return true;
}
}  // namespace

int64_t turnOutwards(Mesh& mesh)
{
	const std::vector<Shell> all = shells(mesh);
	int64_t turned = 0;
	for (const Shell& shell : all)
	{
		bool isCavity = false;
		for (const Shell& other : all)
			if (&other != &shell && encloses(mesh, other, shell)) isCavity = !isCavity;
		if (shell.volume == 0 || (shell.volume < 0) == isCavity) continue;
		++turned;
		for (const uint32_t i : shell.triangles) std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
	}
	return turned;
}
}  // namespace ist
