// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshHoles.h"

#include "BulletISTCollision/Core/Mesh/MeshEdges.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ist
{
namespace
{
/// Share of the mesh's longest side by which a flat part may deviate from its plane.
constexpr double kFlatPart = 1e-6;

constexpr uint32_t kNone = UINT32_MAX;

/// Directed edges (from, to) that the caps must contain, sorted. At each vertex, equally many of them end and begin.
std::vector<std::pair<uint32_t, uint32_t>> missingUses(const Mesh& mesh)
{
	std::vector<std::pair<uint32_t, uint32_t>> missing;
	forEachEdge(sortedEdges(mesh), [&](const EdgeUse* use, std::size_t count) {
		int64_t balance = 0;
		for (std::size_t i = 0; i < count; ++i) balance += use[i].forward ? 1 : -1;
		for (; balance > 0; --balance) missing.emplace_back(use->high, use->low);
		for (; balance < 0; ++balance) missing.emplace_back(use->low, use->high);
	});
	std::sort(missing.begin(), missing.end());
	return missing;
}

double triangleArea(const Mesh& mesh, const Triangle& t)
{
	const Vec3& a = mesh.vertices[t[0]];
	return 0.5 * norm(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a));
}

/// The vertices of connected parts that are not flat. A flat part has no volume, however large the hole in it.
std::vector<uint8_t> verticesOfBodies(const Mesh& mesh)
{
	const std::vector<uint32_t> component = componentOfTriangle(mesh, sortedEdges(mesh));
	const double flat = kFlatPart * bounds(mesh).longestSide();
	std::vector<Vec3> normals(mesh.triangles.size());
	std::vector<uint8_t> isBody(mesh.triangles.size(), 0), ofBody(mesh.vertices.size(), 0);
	const auto normal = [&](const Triangle& t) {
		const Vec3& a = mesh.vertices[t[0]];
		return cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a);
	};
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
		if (const Vec3 n = normal(mesh.triangles[i]); squaredNorm(n) > squaredNorm(normals[component[i]])) normals[component[i]] = n;
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
	{
		const Vec3& on = mesh.vertices[mesh.triangles[component[i]][0]];
		for (const uint32_t v : mesh.triangles[i])
			if (std::fabs(dot(normalized(normals[component[i]]), mesh.vertices[v] - on)) > flat) isBody[component[i]] = 1;
	}
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
		for (const uint32_t v : mesh.triangles[i]) ofBody[v] |= isBody[component[i]];
	return ofBody;
}

bool isFlat(const Mesh& mesh, const uint32_t* loop, std::size_t length)
{
	const Vec3& start = mesh.vertices[loop[0]];
	Vec3 normal;
	double longest = 0;
	for (std::size_t i = 0; i < length; ++i)
	{
		const Vec3 a = mesh.vertices[loop[i]] - start, b = mesh.vertices[loop[(i + 1) % length]] - start;
		normal += cross(a, b);
		longest = std::max(longest, norm(a));
	}
	normal = normalized(normal);
	return std::all_of(
		loop, loop + length, [&](uint32_t v) { return std::fabs(dot(normal, mesh.vertices[v] - start)) <= kFlatPart * longest; });
}

void cap(Mesh& mesh, const uint32_t* loop, std::size_t length, const std::vector<uint8_t>& ofBody, ClosedHoles& closed)
{
	++closed.count;
	const std::size_t first = mesh.triangles.size();
	const Vec3 start = mesh.vertices[loop[0]];
	Box box{start, start};
	Vec3 sum;
	for (std::size_t i = 0; i < length; ++i)
	{
		const Vec3& v = mesh.vertices[loop[i]];
		box.lower = componentMin(box.lower, v);
		box.upper = componentMax(box.upper, v);
		sum += v - start;
	}
	if (length == 3) mesh.triangles.push_back({loop[0], loop[1], loop[2]});
	else
	{
		const auto center = static_cast<uint32_t>(mesh.vertices.size());
		mesh.vertices.push_back(start + sum / static_cast<double>(length));
		for (std::size_t i = 0; i < length; ++i) mesh.triangles.push_back({loop[i], loop[(i + 1) % length], center});
	}
	double area = 0;
	for (std::size_t i = first; i < mesh.triangles.size(); ++i) area += triangleArea(mesh, mesh.triangles[i]);
	// Flat parts that touch, such as a floor and a wall, enclose a volume together with a cap from one to the other.
	const bool isOfBody = std::any_of(loop, loop + length, [&](uint32_t v) { return ofBody[v] != 0; }) || !isFlat(mesh, loop, length);
	const double extent = norm(box.size()), doubt = area * extent / 4;
	(isOfBody ? closed.doubt : closed.doubtOfSheets) += doubt;
	if (doubt > closed.largest.doubt) closed.largest = {doubt, extent, 0.5 * (box.lower + box.upper)};
}
}  // namespace

ClosedHoles closeHoles(Mesh& mesh)
{
	const std::vector<std::pair<uint32_t, uint32_t>> missing = missingUses(mesh);
	ClosedHoles closed;
	if (missing.empty()) return closed;
	const std::size_t vertexCount = mesh.vertices.size();
	std::vector<uint32_t> next(vertexCount + 1, 0), onPath(vertexCount, kNone), path;
	for (const auto& edge : missing) ++next[edge.first + 1];
	for (std::size_t v = 0; v < vertexCount; ++v) next[v + 1] += next[v];
	const std::vector<uint32_t> begin = next;
	const std::vector<uint8_t> ofBody = verticesOfBodies(mesh);

	// The walk cuts off a loop as soon as it meets itself, so no loop passes a vertex twice. Because equally many edges end and begin at
	// each vertex, the walk can only stop where it began.
	for (const auto& seed : missing)
	{
		uint32_t v = seed.first;
		while (true)
		{
			if (onPath[v] != kNone)
			{
				const std::size_t from = onPath[v];
				cap(mesh, path.data() + from, path.size() - from, ofBody, closed);
				for (std::size_t i = from; i < path.size(); ++i) onPath[path[i]] = kNone;
				path.resize(from);
			}
			if (next[v] == begin[v + 1]) break;
			onPath[v] = static_cast<uint32_t>(path.size());
			path.push_back(v);
			v = missing[next[v]++].second;
		}
	}
	return closed;
}
}  // namespace ist
