// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/FlatRegions.h"

#include <algorithm>
#include <utility>

namespace ist
{
namespace
{
constexpr double kSameNormal = 1e-6;
constexpr double kLongVariance = 9;  // ratio of the variances of a rectangle of 3 : 1

using Link = std::pair<uint32_t, uint32_t>;  // two pieces that share an edge and have the same normal

bool faceTheSameWay(const SurfacePiece& a, const SurfacePiece& b) { return squaredNorm(a.normal - b.normal) < kSameNormal * kSameNormal; }

/// All links, in both directions and in ascending order.
std::vector<Link> linksOf(const Mesh& mesh, const std::vector<uint32_t>& triangles, const std::vector<SurfacePiece>& pieces)
{
	std::vector<std::pair<uint64_t, uint32_t>> edges;  // both vertices, piece
	edges.reserve(3 * pieces.size());
	for (size_t i = 0; i < pieces.size(); ++i)
		for (size_t k = 0; k < 3; ++k)
		{
			const auto& t = mesh.triangles[triangles[i]];
			const uint64_t a = t[k], b = t[(k + 1) % 3];
			edges.push_back({std::min(a, b) << 32 | std::max(a, b), uint32_t(i)});
		}
	std::sort(edges.begin(), edges.end());
	std::vector<Link> links;
	for (size_t i = 1; i < edges.size(); ++i)
	{
		const uint32_t a = edges[i - 1].second, b = edges[i].second;
		if (edges[i - 1].first != edges[i].first || !faceTheSameWay(pieces[a], pieces[b])) continue;
		links.push_back({a, b});
		links.push_back({b, a});
	}
	std::sort(links.begin(), links.end());
	return links;
}

/// The pieces that are linked to a seed and have its normal. Marks them as seen.
std::vector<uint32_t> flood(uint32_t seed, const std::vector<Link>& links, const std::vector<SurfacePiece>& pieces, std::vector<char>& seen)
{
	std::vector<uint32_t> members{seed};
	seen[seed] = 1;
	for (size_t i = 0; i < members.size(); ++i)
	{
		auto link = std::lower_bound(links.begin(), links.end(), Link{members[i], 0});
		for (; link != links.end() && link->first == members[i]; ++link)
		{
			const uint32_t next = link->second;
			if (seen[next] || !faceTheSameWay(pieces[next], pieces[seed])) continue;
			seen[next] = 1;
			members.push_back(next);
		}
	}
	return members;
}
}  // namespace

std::vector<Vec3> findFlatRegions(
	const Mesh& mesh, const std::vector<uint32_t>& triangles, std::vector<SurfacePiece>& pieces, double smallestArea)
{
	const std::vector<Link> links = linksOf(mesh, triangles, pieces);
	std::vector<char> seen(pieces.size());
	std::vector<Vec3> centroids;
	for (uint32_t seed = 0; seed < pieces.size(); ++seed)
	{
		if (seen[seed]) continue;
		std::vector<uint32_t> members = flood(seed, links, pieces, seen);
		double area = 0;
		for (const uint32_t i : members) area += pieces[i].area;
		if (area < smallestArea) continue;
		const SurfaceCluster region = clusterOf(pieces, std::move(members));
		if (!region.isFlat || region.frame.variance[0] > kLongVariance * region.frame.variance[1]) continue;
		for (const uint32_t i : region.pieces) pieces[i].region = uint32_t(centroids.size());
		centroids.push_back(region.centroid);
	}
	return centroids;
}
}  // namespace ist
