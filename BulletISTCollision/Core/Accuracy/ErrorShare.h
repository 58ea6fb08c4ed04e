// SPDX-License-Identifier: Zlib
#pragma once

#include <algorithm>

namespace ist
{
/// An error [m^3, for 1 Pa/m] as a share of the true force, of which only the computed force `seen` is known. Up to an error of half of
/// `seen`, it is the share of `seen`. Beyond, the true force may be much smaller than `seen`; it may be zero when the error is as large
/// as `seen`. There the result is the share of the floor. The function is continuous.
inline double shareOfTrueForce(double error, double seen, double floor)
{
	return error / std::max(std::min(seen, 2 * (seen - error)), floor);
}
}  // namespace ist
