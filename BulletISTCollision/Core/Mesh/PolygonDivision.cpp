// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/PolygonDivision.h"

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace ist
{
namespace
{
using Triangles = std::vector<std::array<std::size_t, 3>>;
constexpr std::size_t kMostConcave = 1000;

/// Twice the polygon's area vector (Newell).
Vec3 areaVector(std::span<const Vec3> corners)
{
	Vec3 sum;
	for (std::size_t i = 1; i + 1 < corners.size(); ++i) sum += cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
	return sum;
}

Triangles fan(std::size_t corners)
{
	Triangles triangles;
	for (std::size_t i = 1; i + 1 < corners; ++i) triangles.push_back({0, i, i + 1});
	return triangles;
}

/// Cuts off triangles whose corner is convex and that contain no other corner. A corner that was refused is looked at again only when one
/// of its neighbours, or the corner in its triangle, was cut off, and then from there on. So O(n^2) corners are compared at most.
class EarClipping
{
public:
	EarClipping(std::span<const Vec3> corners, const Vec3& normal)
		: m_corners(corners),
		  m_normal(normal),
		  m_left(corners.size()),
		  m_refusals(corners.size())
	{
		std::iota(m_left.begin(), m_left.end(), std::size_t(0));
	}
	/// Empty if no ear is found, as in a polygon that cuts itself.
	Triangles run()
	{
		Triangles triangles;
		while (m_left.size() > 3)
		{
			const std::size_t ear = findEar();
			if (ear == m_left.size()) return {};
			const std::size_t before = at(ear + m_left.size() - 1), corner = at(ear), behind = at(ear + 1);
			triangles.push_back({before, corner, behind});
			m_left.erase(m_left.begin() + std::ptrdiff_t(ear));
			m_refusals[corner].isCut = true;
			m_refusals[before] = m_refusals[behind] = {};
		}
		triangles.push_back({m_left[0], m_left[1], m_left[2]});
		return triangles;
	}
	std::uint64_t comparisons() const { return m_comparisons; }

private:
	static constexpr std::size_t kNone = SIZE_MAX;
	/// What is known of a corner and its present neighbours.
	struct Refusal
	{
		std::size_t inside = kNone;  ///< the first corner that lies in their triangle
		bool isConcave = false;
		bool isCut = false;  ///< the corner is no longer there
	};

	std::size_t at(std::size_t i) const { return m_left[i % m_left.size()]; }
	double turn(const Vec3& a, const Vec3& b, const Vec3& c) const { return dot(m_normal, cross(b - a, c - a)); }

	std::size_t findEar()
	{
		std::size_t i = 0;
		while (i < m_left.size() && !isEar(i)) ++i;
		return i;
	}
	bool isEar(std::size_t i)
	{
		Refusal& refusal = m_refusals[at(i)];
		if (refusal.isConcave || (refusal.inside != kNone && !m_refusals[refusal.inside].isCut)) return false;
		const Vec3 &a = m_corners[at(i + m_left.size() - 1)], &b = m_corners[at(i)], &c = m_corners[at(i + 1)];
		refusal.isConcave = !(turn(a, b, c) > 0);
		if (refusal.isConcave) return false;
		const auto first = refusal.inside == kNone ? m_left.begin() : std::lower_bound(m_left.begin(), m_left.end(), refusal.inside);
		for (auto other = first; other != m_left.end(); ++other)
		{
			const Vec3& p = m_corners[*other];
			++m_comparisons;
			if (p == a || p == b || p == c) continue;
			if (!(turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0)) continue;
			refusal.inside = *other;
			return false;
		}
		return true;
	}

	std::span<const Vec3> m_corners;
	Vec3 m_normal;
	std::vector<std::size_t> m_left;  // ascending
	std::vector<Refusal> m_refusals;  // for each corner
	std::uint64_t m_comparisons = 0;
};
}  // namespace

Triangles dividedPolygon(std::span<const Vec3> corners, std::uint64_t* comparisons)
{
	if (comparisons) *comparisons = 0;
	if (corners.size() <= 3) return fan(corners.size());
	const Vec3 normal = areaVector(corners);
	bool isConvex = true;
	for (std::size_t i = 0; i < corners.size() && isConvex; ++i)
	{
		const Vec3 &a = corners[i], &b = corners[(i + 1) % corners.size()], &c = corners[(i + 2) % corners.size()];
		isConvex = dot(normal, cross(b - a, c - b)) >= 0;
	}
	if (isConvex || corners.size() > kMostConcave) return fan(corners.size());
	EarClipping clipping(corners, normal);
	Triangles triangles = clipping.run();
	if (comparisons) *comparisons = clipping.comparisons();
	return triangles.empty() ? fan(corners.size()) : triangles;
}
}  // namespace ist
