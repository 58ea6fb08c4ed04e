// SPDX-License-Identifier: Zlib
#pragma once

#include <algorithm>

namespace ist
{
/// An error [m^3, for 1 Pa/m] as a share of the true force, of which only the computed force `seen` is known. While the error is at most
/// half of `seen`, it is the share of `seen`. Beyond, the true force may be much smaller, so the result is the share of 2 (seen - error).
/// When the error is as large as `seen`, the true force may be zero, and the result is the share of `floor`. The function is continuous.
inline double shareOfTrueForce(double error, double seen, double floor)
{
	return error / std::max(std::min(seen, 2 * (seen - error)), floor);
}
}  // namespace ist
