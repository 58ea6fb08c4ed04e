// SPDX-License-Identifier: Zlib
#pragma once

#include <algorithm>

namespace ist
{
/// An error [m^3, for 1 Pa/m] as a share of the true force, of which only `seen` is known. Up to a half of what is seen the share is of
/// that; beyond, the true force may be a small part of it, and nothing when the error is as large: then it is a share of the floor.
/// Continuous.
inline double shareOfTrueForce(double error, double seen, double floor)
{
	return error / std::max(std::min(seen, 2 * (seen - error)), floor);
}
}  // namespace ist
