// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Force/PressureField.h"

#include "BulletISTCollision/Core/Base/SymmetricEigen.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace ist
{
namespace
{
/// Whether elimination without row exchanges finds only positive pivots, with a margin for rounding. Cost: a tenth of an eigenvalue
/// problem.
bool isPositiveDefinite(const SymmetricMatrix6& matrix)
{
	constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon();
	double rows[6][6];
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j) rows[i][j] = matrix(i, j);
	for (int k = 0; k < 6; ++k)
	{
		if (!(rows[k][k] > kRounding * matrix(k, k))) return false;
		const double inverse = 1 / rows[k][k];
		for (int i = k + 1; i < 6; ++i)
		{
			const double factor = rows[k][i] * inverse;
			for (int j = i; j < 6; ++j) rows[i][j] -= factor * rows[k][j];
		}
	}
	return true;
}

double densityAt(const InnerSphereTree& A, const InnerSphereTree& B, int level)
{
	const LevelPair trees = levelOf(A, B, level);
	// slotCount() stands for the number of balls, because all blocks of a tree but the last few are full.
	return std::min(double(trees.treeA->slotCount()) / A.volume, double(trees.treeB->slotCount()) / B.volume);
}
}  // namespace

Wrench pressureWrench(const OverlapIntegrals& integrals, const PressurePair& pair)
{
	return pair.stiffness * (pair.weightB * integrals.normalB - pair.weightA * integrals.normalA);
}

double frictionFactor(const OverlapIntegrals& integrals)
{
	const double a = norm(integrals.normalA.force), b = norm(integrals.normalB.force);
	if (!(a > 0) || !(b > 0)) return 1;
	return std::clamp(std::min(integrals.pressedA / a, integrals.pressedB / b), 1.0, std::numbers::sqrt2);
}

double pressureEnergy(const OverlapIntegrals& integrals, const PressurePair& pair)
{
	return pair.stiffness * (pair.weightA * integrals.depthA + pair.weightB * integrals.depthB);
}

SymmetricMatrix6 pressureStiffness(const OverlapIntegrals& integrals, const PressurePair& pair)
{
	SymmetricMatrix6 K;
	// stiffnessA already includes the minus sign of A's field.
	for (int i = 0; i < 21; ++i)
		K.m[i] = pair.stiffness * (pair.weightA * integrals.stiffnessA.m[i] + pair.weightB * integrals.stiffnessB.m[i]);
	return K;
}

SymmetricMatrix6 pressureDamping(const OverlapIntegrals& integrals, const PressurePair& pair)
{
	SymmetricMatrix6 D = integrals.damping;
	for (double& d : D.m) d *= pair.stiffness;
	return D;
}

SymmetricMatrix6 projectedPositive(const SymmetricMatrix6& matrix, double length)
{
	if (isPositiveDefinite(matrix)) return matrix;
	const double unit = length > 0 && std::isfinite(length) ? length : 1;
	const double scale[6] = {1, 1, 1, 1 / unit, 1 / unit, 1 / unit};
	double scaled[6][6];
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j) scaled[i][j] = scaled[j][i] = matrix(i, j) * scale[i] * scale[j];
	SymmetricMatrix6 result;
	SymmetricEigen<6> eigen;
	if (!eigen.decompose(scaled)) return result;
	double positive[6][6] = {};
	for (int k = 0; k < 6; ++k)
	{
		if (!(eigen.values[k] > 0)) continue;
		for (int i = 0; i < 6; ++i)
		{
			const double share = eigen.values[k] * eigen.vectors[k][i];
			for (int j = 0; j < 6; ++j) positive[i][j] += share * eigen.vectors[k][j];
		}
	}
	const double back[6] = {1, 1, 1, unit, unit, unit};
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j) result(i, j) = positive[i][j] * back[i] * back[j];
	return result;
}

Wrench operator*(const SymmetricMatrix6& matrix, const Twist& twist)
{
	const double x[6] = {twist.linear.x, twist.linear.y, twist.linear.z, twist.angular.x, twist.angular.y, twist.angular.z};
	double y[6] = {};
	const double* next = matrix.m;
	for (int i = 0; i < 6; ++i)
	{
		y[i] += *next++ * x[i];
		for (int j = i + 1; j < 6; ++j, ++next)
		{
			y[i] += *next * x[j];
			y[j] += *next * x[i];
		}
	}
	return {{y[0], y[1], y[2]}, {y[3], y[4], y[5]}};
}

double meanDepth(const OverlapIntegrals& integrals)
{
	const double volume = integrals.volume, area = norm(integrals.areaVector), widest = 2 * std::cbrt(std::max(volume, 0.0));
	return area * widest > volume ? volume / area : widest;
}

OverlapError overlapError(const OverlapIntegrals& integrals, double lengthSum, double leafDensity, double stiffness)
{
	const double V = integrals.volume;
	if (!(V > 0)) return {};
	const double across = std::cbrt(leafDensity * V) + kLeastAcross;
	const double relativeGap = lengthSum * norm(integrals.areaVector) / V;
	const double r = kGapError * relativeGap * relativeGap;
	const double ofSurfaces = std::min(integrals.surfaceVolume, V), ofLeaves = V - ofSurfaces;
	const double volumeOfLeaves = ofLeaves * std::hypot(kVolumeError / std::pow(across, kVolumePower), r);
	const double forceOfLeaves = ofLeaves * std::hypot(kForceError / std::pow(across, kForcePower), r);
	const double ofFaces = std::sqrt(integrals.forceVariance), ofCuts = std::sqrt(integrals.volumeVariance);
	return {std::hypot(volumeOfLeaves, std::hypot(kFaceVolumeError * ofFaces, ofCuts, kSurfaceVolumeError * ofSurfaces)),
		stiffness * std::hypot(forceOfLeaves, kFaceForceError * ofFaces, kSurfaceForceError * ofSurfaces)};
}

OverlapError overlapError(const OverlapResult& answer, const InnerSphereTree& A, const InnerSphereTree& B, double stiffness)
{
	return overlapError(answer.total, A.errorLength() + B.errorLength(), leafDensity(answer, A, B), stiffness);
}

OverlapError overlapError(const OverlapResult& answer, const InnerSphereTree& body, double stiffness)
{
	return overlapError(answer.total, body.errorLength(), leafDensity(body), stiffness);
}

double leafDensity(const OverlapResult& answer, const InnerSphereTree& A, const InnerSphereTree& B)
{
	const double density = densityAt(A, B, answer.level), share = answer.levelShare;
	if (share == 1) return density;
	constexpr double kPower = kForcePower / 3;
	return std::pow(share * std::pow(density, -kPower) + (1 - share) * std::pow(densityAt(A, B, answer.otherLevel), -kPower), -1 / kPower);
}

double leafDensity(const InnerSphereTree& body) { return double(body.law.slotCount()) / body.volume; }
}  // namespace ist
