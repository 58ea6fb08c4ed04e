// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <memory>

namespace scenes
{
/// The overlap of two closed meshes, integrated directly on their triangles. Axes of A's mesh frame.
struct QuadratureTruth
{
	double volume = 0;              ///< [m^3]
	double volumeError = 0;         ///< standard error, from the spread of the three line directions [m^3]
	ist::Vec3 centroid;             ///< [m], zero without overlap
	ist::Wrench normalA, normalB;   ///< Int n dV [m^3] and Int (x - about) x n dV [m^4], n the outward normal of the nearest surface point
	double normalError = 0;         ///< standard error of (normalB - normalA).force / 2 [m^3]
	double depthA = 0, depthB = 0;  ///< Int depth dV [m^4]
	int unbalancedLines = 0;        ///< number of lines that left a mesh more or less often than they entered it; they count as empty

	/// Force on A for stiffness 1 Pa/m and the given weights, torque about `about`.
	ist::Wrench wrench(double weightA = 0.5, double weightB = 0.5) const { return weightB * normalB - weightA * normalA; }
};

/// Ground truth that shares no algorithm with the library. It is exact inside intervals along jittered lines of three directions. In
/// these intervals it takes sample points, with the nearest point of each surface. Immutable: any number of threads may integrate.
class OverlapQuadrature
{
public:
	/// Both meshes must be closed and oriented outwards.
	OverlapQuadrature(const ist::Mesh& A, const ist::Mesh& B);
	~OverlapQuadrature();
	OverlapQuadrature(OverlapQuadrature&&) noexcept;

	/// Integrates with linesPerAxis^2 lines in each of three directions. With `pointsTotal` = 0 only the volume is computed.
	/// Deterministic for a seed.
	QuadratureTruth integrate(const ist::Pose& X_AB, const ist::Vec3& about, int linesPerAxis, int pointsTotal, uint64_t seed = 1) const;

	/// Volume of a body [m^3], its centroid, and the largest distance of a vertex from it [m].
	struct Extent
	{
		double volume = 0;
		ist::Vec3 center;
		double radius = 0;
	};
	const Extent& extentA() const;
	const Extent& extentB() const;

private:
	struct Implementation;
	std::unique_ptr<Implementation> m_impl;
};
}  // namespace scenes
