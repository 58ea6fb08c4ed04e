// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Surface/Partition/DepthSample.h"

#include <span>

namespace ist
{
/// depth(x) = depth + gradient . y + y^T H y / 2 with y = x - center.
struct Quadric
{
	Vec3 center;
	double depth = 0;
	Vec3 gradient;
	double hessian[6] = {};  ///< xx, yy, zz, xy, xz, yz

	Vec3 slope(const Vec3& y) const
	{
		const double(&h)[6] = hessian;
		return {h[0] * y.x + h[3] * y.y + h[4] * y.z, h[3] * y.x + h[1] * y.y + h[5] * y.z, h[4] * y.x + h[5] * y.y + h[2] * y.z};
	}
	double depthAt(const Vec3& x) const
	{
		const Vec3 y = x - center;
		return depth + dot(gradient + slope(y) * 0.5, y);
	}
	Vec3 gradientAt(const Vec3& x) const { return gradient + slope(x - center); }
};

struct QuadricFit
{
	Quadric quadric;
	double squares = 0;  ///< weighted sum of the squared errors [1]
	double largest = 0;  ///< largest error [m]
	double error = 0;    ///< root mean square error of the samples that are not outside [m]
	double radius = 0;   ///< root mean square distance of these samples from the center [m]
	size_t within = 0;   ///< number of samples that are not outside
};

/// Error of a fit at a sample [m]. Where the sample is outside and not an equation of the fit, it is by how much the
/// value is too large.
double errorAt(const QuadricFit& fit, const DepthSample& sample, double spacing);

/// Fits a quadric to samples by weighted least squares. Depth and gradient of samples in the body and on its surface are equations.
/// Samples outside are inequalities: there the quadric must be negative. So the rounded distance field
/// beyond an edge does not bend the field of the faces inside. If all samples are outside, their depths are equations.
/// `center`: rounded to floats. `spacing`: typical size of a cell [m].
QuadricFit fitQuadric(std::span<const DepthSample> samples, double spacing);
}  // namespace ist
