// SPDX-License-Identifier: Zlib
#pragma once

#include <cmath>

namespace ist
{
/// Eigenvalues of the symmetric matrix [[uu, uv], [uv, vv]], and the angle of the larger one's axis from u towards v [rad].
struct PlaneAxes
{
	double larger, smaller, angle;

	PlaneAxes(double uu, double vv, double uv)
	{
		const double mean = 0.5 * (uu + vv), half = std::hypot(0.5 * (uu - vv), uv);
		larger = mean + half;
		smaller = mean - half;
		angle = 0.5 * std::atan2(uv, 0.5 * (uu - vv));
	}
};
}  // namespace ist
