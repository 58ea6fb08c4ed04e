// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"

#include <array>

namespace browser
{
/// A 4x4 matrix, column major as OpenGL reads it.
struct Matrix4
{
	std::array<float, 16> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
	float operator()(int row, int column) const { return m[size_t(4 * column + row)]; }
	float& operator()(int row, int column) { return m[size_t(4 * column + row)]; }
};
Matrix4 operator*(const Matrix4& a, const Matrix4& b);
/// Matrix of a rigid pose, after the model's lengths are multiplied by `scale`.
Matrix4 matrixOf(const ist::Pose& X, double scale = 1);
/// Perspective that looks along -z; `verticalAngle` [rad] is between the lower and the upper edge.
Matrix4 perspective(double verticalAngle, double aspect, double nearest, double farthest);
/// Orthographic projection of the box |x|, |y| <= half, -farthest <= z <= -nearest.
Matrix4 orthographic(double half, double nearest, double farthest);
/// Inverse of a perspective matrix.
Matrix4 inversePerspective(const Matrix4& p);
}  // namespace browser
