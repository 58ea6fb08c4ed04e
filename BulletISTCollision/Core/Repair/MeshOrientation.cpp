// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshOrientation.h"

#include "BulletISTCollision/Core/Mesh/MeshEdges.h"

#include <array>
#include <utility>
#include <vector>

namespace ist
{
int64_t orientConsistently(Mesh& mesh)
{
	struct Neighbour
	{
		uint32_t triangle = UINT32_MAX;
		bool agrees = true;
	};
	std::vector<std::array<Neighbour, 3>> neighbours(mesh.triangles.size());
	std::vector<uint8_t> count(mesh.triangles.size(), 0);
	forEachEdge(sortedEdges(mesh), [&](const EdgeUse* use, std::size_t uses) {
		if (uses != 2) return;
		const bool agrees = use[0].forward != use[1].forward;
		for (int i = 0; i < 2; ++i) neighbours[use[i].triangle][count[use[i].triangle]++] = {use[1 - i].triangle, agrees};
	});

	enum : uint8_t
	{
		Unknown,
		Stays,
		Turns
	};
	std::vector<uint8_t> verdict(mesh.triangles.size(), Unknown);
	std::vector<uint32_t> reached;
	for (uint32_t seed = 0; seed < mesh.triangles.size(); ++seed)
	{
		if (verdict[seed] != Unknown) continue;
		verdict[seed] = Stays;
		reached.assign(1, seed);
		std::size_t turns = 0;
		for (std::size_t i = 0; i < reached.size(); ++i)
		{
			const uint32_t t = reached[i];
			turns += verdict[t] == Turns;
			for (uint8_t k = 0; k < count[t]; ++k)
			{
				const Neighbour n = neighbours[t][k];
				if (verdict[n.triangle] != Unknown) continue;
				verdict[n.triangle] = (verdict[t] == Stays) == n.agrees ? Stays : Turns;
				reached.push_back(n.triangle);
			}
		}
		if (2 * turns <= reached.size()) continue;
		for (const uint32_t t : reached) verdict[t] = verdict[t] == Turns ? Stays : Turns;
	}
	int64_t turned = 0;
	for (std::size_t i = 0; i < verdict.size(); ++i)
		if (verdict[i] == Turns)
		{
			std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
			++turned;
		}
	return turned;
}

void faceOutwards(Mesh& mesh)
{
	orientConsistently(mesh);
	const std::vector<uint32_t> component = componentOfTriangle(mesh, sortedEdges(mesh));
	std::vector<double> volume(mesh.triangles.size(), 0);
	const Vec3 middle = 0.5 * (bounds(mesh).lower + bounds(mesh).upper);
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
	{
		const Triangle& t = mesh.triangles[i];
		volume[component[i]] += dot(mesh.vertices[t[0]] - middle, cross(mesh.vertices[t[1]] - middle, mesh.vertices[t[2]] - middle));
	}
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
		if (volume[component[i]] < 0) std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
}
}  // namespace ist
