// SPDX-License-Identifier: Zlib
#include "demos/browser/render/Matrix4.h"

#include <cmath>

namespace browser
{
Matrix4 operator*(const Matrix4& a, const Matrix4& b)
{
	Matrix4 c;
	for (int i = 0; i < 4; ++i)
		for (int j = 0; j < 4; ++j)
		{
			c(i, j) = 0;
			for (int k = 0; k < 4; ++k) c(i, j) += a(i, k) * b(k, j);
		}
	return c;
}

Matrix4 matrixOf(const ist::Pose& X, double scale)
{
	Matrix4 m;
	for (int i = 0; i < 3; ++i)
	{
		for (int j = 0; j < 3; ++j) m(i, j) = float(scale * X.rotation.m[i][j]);
		m(i, 3) = float(X.translation[i]);
	}
	return m;
}

Matrix4 perspective(double verticalAngle, double aspect, double nearest, double farthest)
{
	const double f = 1 / std::tan(verticalAngle / 2);
	Matrix4 p;
	p(0, 0) = float(f / aspect);
	p(1, 1) = float(f);
	p(2, 2) = float((farthest + nearest) / (nearest - farthest));
	p(2, 3) = float(2 * farthest * nearest / (nearest - farthest));
	p(3, 2) = -1;
	p(3, 3) = 0;
	return p;
}

Matrix4 orthographic(double half, double nearest, double farthest)
{
	Matrix4 p;
	p(0, 0) = p(1, 1) = float(1 / half);
	p(2, 2) = float(-2 / (farthest - nearest));
	p(2, 3) = float(-(farthest + nearest) / (farthest - nearest));
	return p;
}

Matrix4 inversePerspective(const Matrix4& p)
{
	Matrix4 q;
	q(0, 0) = 1 / p(0, 0);
	q(1, 1) = 1 / p(1, 1);
	q(2, 2) = 0;
	q(2, 3) = -1;
	q(3, 2) = 1 / p(2, 3);
	q(3, 3) = p(2, 2) / p(2, 3);
	return q;
}
}  // namespace browser
