// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Vec3.h"

#include <span>
#include <vector>

namespace ist
{
/// Appends the part of a convex polygon where a linear function of the position is not negative; fewer than three corners where it has no
/// area. `onCut(x)` gets each new corner, where an edge is cut. `out` is not the polygon. O(corners).
template <class Function, class OnCut>
void clipPolygon(std::span<const Vec3> polygon, const Function& function, const OnCut& onCut, std::vector<Vec3>& out)
{
	for (size_t i = 0; i < polygon.size(); ++i)
	{
		const Vec3 &p = polygon[i], &q = polygon[i + 1 < polygon.size() ? i + 1 : 0];
		const double a = function(p), b = function(q);
		if (a >= 0) out.push_back(p);
		if ((a >= 0) == (b >= 0)) continue;
		out.push_back(p + (q - p) * (a / (a - b)));
		onCut(out.back());
	}
}

/// Returns that part as a polygon of its own.
template <class Function, class OnCut>
std::vector<Vec3> clippedPolygon(const std::vector<Vec3>& polygon, const Function& function, const OnCut& onCut)
{
	std::vector<Vec3> kept;
	kept.reserve(polygon.size() + 1);
	clipPolygon(polygon, function, onCut, kept);
	return kept;
}

template <class Function> std::vector<Vec3> clippedPolygon(const std::vector<Vec3>& polygon, const Function& function)
{
	return clippedPolygon(polygon, function, [](const Vec3&) {});
}
}  // namespace ist
