// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

#include <vector>

namespace ist
{
/// What one setting promises and costs over the poses.
struct TuneSetting
{
	size_t spheres = 0;                  ///< of the larger packing
	int level = 0;                       ///< -1: chosen anew in every pose
	double error = 0;                    ///< force error that 95 % of the poses stay under, of max(|F|, floor)
	double microseconds = 0, pairs = 0;  ///< median; mean
	int patches = 0;                     ///< that 95 % of the poses have at most: what a solver has rows for
};

/// A contact of the two bodies, as the leaves see it in one of the poses.
struct TuneContact
{
	double volume = 0, area = 0;  ///< of the overlap; length of its area vector [m^3, m^2]
};

struct TuneSettings
{
	std::vector<TuneSetting> settings;  ///< all fixed levels, the finest first, and at the end the choice by pose
	std::vector<TuneContact> contacts;
};

/// Asks both trees, with levels, at every level in seeded poses of `kOverlapsOfContact`; the choice by pose accepts `acceptedError`. The
/// same for two trees, but for the times. `progress` (stage "tune") hears of each query and may be empty. Errors: BULLETHAPTICS_ISA names
/// what cannot run here, no pose overlaps, a query is refused, cancelled.
Result<TuneSettings> measureSettings(
	const InnerSphereTree& A, const InnerSphereTree& B, double acceptedError, const Progress& progress = {});
}  // namespace ist
