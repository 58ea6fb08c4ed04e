// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Surface/DepthField.h"

namespace ist
{
/// Depth and gradient of a cell's polynomial, in single precision. Not installed.
struct CellDepth
{
	float depth;
	float gradient[3];
};

inline void timesHessian(const DepthCell& cell, const float* y, float* out)
{
	const float* h = cell.hessian;
	out[0] = h[0] * y[0] + h[3] * y[1] + h[4] * y[2];
	out[1] = h[3] * y[0] + h[1] * y[1] + h[5] * y[2];
	out[2] = h[4] * y[0] + h[5] * y[1] + h[2] * y[2];
}

inline float dot3(const float* a, const float* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

inline CellDepth depthIn(const DepthCell& cell, const float* x)
{
	const float y[3] = {x[0] - cell.center[0], x[1] - cell.center[1], x[2] - cell.center[2]};
	float hy[3];
	timesHessian(cell, y, hy);
	return {cell.depth + dot3(cell.gradient, y) + 0.5f * dot3(y, hy),
		{cell.gradient[0] + hy[0], cell.gradient[1] + hy[1], cell.gradient[2] + hy[2]}};
}

/// By how much the depth's gradient changes along a way within a cell.
inline Vec3 gradientChange(const DepthCell& cell, const Vec3& way)
{
	const float y[3] = {float(way.x), float(way.y), float(way.z)};
	float change[3];
	timesHessian(cell, y, change);
	return {change[0], change[1], change[2]};
}
}  // namespace ist
