// SPDX-License-Identifier: Zlib
#pragma once

#include <cmath>

namespace ist
{
/// Limits of what a surface or a depth field from a file may state. Built ones are orders of magnitude below them. Within them no query
/// overflows a float, so that every sum of a query is finite.

/// Coordinates, lengths and depths [m]; the same as kMostReach (TreeLimits.h).
constexpr float kFarthest = 5e7f;
/// Length of the gradient of a depth; exact depths have 1.
constexpr float kSteepest = 1e3f;
/// Curvature of a depth times the size of its field, and change of the normal over an element.
constexpr float kMostBent = 1e8f;

inline bool isNear(double v) { return std::fabs(v) < kFarthest; }
template <int N> bool areNear(const float (&values)[N])
{
	for (float v : values)
		if (!isNear(v)) return false;
	return true;
}
}  // namespace ist
