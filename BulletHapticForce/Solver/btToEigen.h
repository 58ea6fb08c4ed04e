// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"

#include <Eigen/Core>

/// Conversions from the project's types to Eigen's. Not installed.
namespace btToEigen
{
inline Eigen::Vector3d toEigen(const ist::Vec3& v) { return {v.x, v.y, v.z}; }

inline Eigen::Matrix<double, 6, 1> toEigen(const ist::Vec3& a, const ist::Vec3& b)
{
	Eigen::Matrix<double, 6, 1> r;
	r << a.x, a.y, a.z, b.x, b.y, b.z;
	return r;
}

inline Eigen::Matrix3d toEigen(const ist::Mat3& a)
{
	Eigen::Matrix3d r;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) r(i, j) = a.m[i][j];
	return r;
}

inline Eigen::Matrix<double, 6, 6> toEigen(const ist::SymmetricMatrix6& a)
{
	Eigen::Matrix<double, 6, 6> r;
	const double* next = a.m;
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j) r(i, j) = r(j, i) = *next++;
	return r;
}

/// The matrix whose product with w is the cross product of v and w.
inline Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& v)
{
	Eigen::Matrix3d r;
	r << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
	return r;
}
}  // namespace btToEigen
