// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

/// Friction of one patch that is no longer than `limit` and leaves the least slip. All vectors are along the axes in which each part of
/// the friction changes only its own slip, by the factor `yielding`.
///
/// The solution is (yielding + m) wanted = yielding now - slip, with the smallest m >= 0 that keeps the limit. Newton's method for
/// 1/|wanted| approaches it from below and does not overshoot; from above, one step leads below. `excess` is m, and the start of the
/// search for it.
inline Eigen::Vector3d btFrictionWithinLimit(
	double limit, const Eigen::Vector3d& now, const Eigen::Vector3d& slip, const double* yielding, double& excess)
{
	Eigen::Vector3d wanted;
	for (int i = 0; i < 3; ++i) wanted(i) = yielding[i] > 0 ? now(i) - slip(i) / yielding[i] : now(i);
	if (wanted.squaredNorm() <= limit * limit) return wanted;
	if (!(limit > 0)) return Eigen::Vector3d::Zero();
	Eigen::Vector3d pull;
	double least = 0;
	for (int i = 0; i < 3; ++i)
	{
		pull(i) = yielding[i] * now(i) - slip(i);
		least = std::max(least, std::fabs(pull(i)) / limit - yielding[i]);
	}
	// Each Newton step doubles the number of correct digits.
	constexpr int kMostNewtonSteps = 20;
	constexpr double kLimitTolerance = 1e-12;
	excess = std::max(excess, least);
	double length = limit;
	for (int i = 0; i < kMostNewtonSteps; ++i)
	{
		double square = 0, slope = 0;
		for (int k = 0; k < 3; ++k)
		{
			const double inverse = yielding[k] + excess > 0 ? 1 / (yielding[k] + excess) : 0;
			wanted(k) = pull(k) * inverse;
			square += wanted(k) * wanted(k);
			slope += wanted(k) * wanted(k) * inverse;
		}
		length = std::sqrt(square);
		if (std::fabs(length - limit) <= kLimitTolerance * limit || !(slope > 0)) break;
		excess = std::max(excess + (length - limit) * square / (limit * slope), least);
	}
	return wanted * (limit / std::max(limit, length));
}
