// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/CounterRandom.h"
#include "BulletISTCollision/Core/Surface/Partition/QuadricFit.h"

#include <optional>
#include <span>

namespace ist
{
/// The plane { x : normal . x = offset }.
struct SplitPlane
{
	Vec3 normal;
	double offset = 0;
	double beyond(const Vec3& x) const { return dot(normal, x) - offset; }
};

/// The plane that leaves the smallest residual when a quadric is fitted on each side. Candidates are planes across the principal axes of
/// the samples, bisectors of two faces, where the depth has a crease, and the linear discriminant of two clusters of normals. Looks at
/// some hundred of the samples, among them the worst of `fit`, the fit of all. Empty if no plane leaves enough of them on each side.
std::optional<SplitPlane> findSplitPlane(
	std::span<const DepthSample> samples, const QuadricFit& fit, double spacing, double rounding, CounterRandom random);
}  // namespace ist
