// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

#include <vector>

namespace ist
{
/// Error bound and cost of one setting over the poses.
struct TuneSetting
{
	size_t spheres = 0;                  ///< number of spheres of the larger packing
	int level = 0;                       ///< -1: chosen in each pose
	double error = 0;                    ///< force error that 95 % of the poses do not exceed, as a share of max(|F|, floor)
	double microseconds = 0, pairs = 0;  ///< median time; mean number of pairs
	int patches = 0;                     ///< number of patches that 95 % of the poses do not exceed; a solver needs rows for them
};

/// A contact of the two bodies in one of the poses, measured with the leaves.
struct TuneContact
{
	double volume = 0, area = 0;  ///< overlap volume [m^3]; length of its area vector [m^2]
};

struct TuneSettings
{
	std::vector<TuneSetting> settings;  ///< all fixed levels, the finest first, and the choice by pose at the end
	std::vector<TuneContact> contacts;
};

/// Queries two trees that have levels, at every level, in seeded poses of `kOverlapsOfContact`. The choice by pose has the tolerance
/// `acceptedError`. The result depends only on the two trees, except for the times. `progress` (stage "tune") is called for each query
/// and may be empty. Errors: BULLETHAPTICS_ISA names an instruction set that cannot run here, no pose overlaps, a query is refused,
/// cancelled.
Result<TuneSettings> measureSettings(
	const InnerSphereTree& A, const InnerSphereTree& B, double acceptedError, const Progress& progress = {});
}  // namespace ist
