// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/PressureField.h"

#include <Eigen/Eigenvalues>

#include <cmath>

namespace ist
{
Wrench pressureWrench(const OverlapIntegrals& integrals, const PressurePair& pair)
{
	return pair.stiffness * (pair.weightB * integrals.normalB - pair.weightA * integrals.normalA);
}

double pressureEnergy(const OverlapIntegrals& integrals, const PressurePair& pair)
{
	return pair.stiffness * (pair.weightA * integrals.depthA + pair.weightB * integrals.depthB);
}

SymmetricMatrix6 pressureStiffness(const OverlapIntegrals& integrals, const PressurePair& pair)
{
	SymmetricMatrix6 K;
	// stiffnessA carries the minus sign of A's field already.
	for (int i = 0; i < 21; ++i)
		K.m[i] = pair.stiffness * (pair.weightA * integrals.stiffnessA.m[i] + pair.weightB * integrals.stiffnessB.m[i]);
	return K;
}

SymmetricMatrix6 projectedPositive(const SymmetricMatrix6& matrix, double length)
{
	using Matrix = Eigen::Matrix<double, 6, 6>;
	const double unit = length > 0 && std::isfinite(length) ? length : 1;
	const double scale[6] = {1, 1, 1, 1 / unit, 1 / unit, 1 / unit};
	Matrix scaled;
	for (int i = 0; i < 6; ++i)
		for (int j = 0; j < 6; ++j) scaled(i, j) = matrix(i, j) * scale[i] * scale[j];
	SymmetricMatrix6 result;
	if (!scaled.allFinite()) return result;
	const Eigen::SelfAdjointEigenSolver<Matrix> solver(scaled);
	if (solver.info() != Eigen::Success) return result;
	const Matrix& Q = solver.eigenvectors();
	const Matrix positive = Q * solver.eigenvalues().cwiseMax(0.0).asDiagonal() * Q.transpose();
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j) result(i, j) = 0.5 * (positive(i, j) + positive(j, i)) / (scale[i] * scale[j]);
	return result;
}

Wrench operator*(const SymmetricMatrix6& matrix, const Twist& twist)
{
	const double x[6] = {twist.linear.x, twist.linear.y, twist.linear.z, twist.angular.x, twist.angular.y, twist.angular.z};
	double y[6] = {};
	for (int i = 0; i < 6; ++i)
		for (int j = 0; j < 6; ++j) y[i] += matrix(i, j) * x[j];
	return {{y[0], y[1], y[2]}, {y[3], y[4], y[5]}};
}

OverlapError overlapError(const OverlapIntegrals& integrals, double lengthSum, double stiffness)
{
	const double V = integrals.volume;
	if (!(V > 0)) return {};
	const double S = std::sqrt(integrals.spread) / V;
	const double relativeGap = lengthSum * norm(integrals.areaVector) / V;
	const double r = kGapError * relativeGap * relativeGap;
	return {V * std::hypot(kVolumeSpread * S, r), stiffness * V * std::hypot(kForceSpread * S, r)};
}
}  // namespace ist
