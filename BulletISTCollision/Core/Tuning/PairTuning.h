// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "BulletISTCollision/Core/Tuning/TimeStepAdvice.h"
#include "BulletISTCollision/Core/Tuning/TuneSettings.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ist
{
/// One of the two bodies: a tree, or a mesh of which trees are built.
struct TuneBody
{
	std::string name;  ///< with which a sentence about its mesh begins; may be empty
	std::optional<Mesh> mesh;
	InnerSphereTree tree;  ///< of a mesh the last that was built; afterwards with levels
};

struct TuneOptions
{
	double error = 0.05;         ///< force error accepted between 0.1 and 20 % overlap, above 0 and at most 1
	int64_t maxSpheres = 30000;  ///< of a mesh's tree
	WorldSetup world;            ///< with neither stiffness nor mass, nothing is said of the world
	Progress progress;           ///< stages of `buildTree`, and "tune"; may be empty
};

struct PairTuning
{
	TuneSetting best;   ///< the cheapest fixed level that promises the error; when none does, that of the smallest error bound
	bool kept = false;  ///< it promises the error
	size_t spheresA = 0, spheresB = 0;      ///< of the trees that it is for
	std::vector<TuneSetting> alternatives;  ///< all levels of all trees that were looked at
	std::optional<TimeStepAdvice> world;
};

/// The cheapest setting of two bodies, which may be one and the same, that promises a force error: the levels of their trees, and of a mesh
/// trees of 1,000, 3,000, 9,000 ... spheres until one will do. The same for two bodies, but for the times and what is chosen by them. A
/// fraction of a second, and what building takes. Errors: a mesh that cannot be built, half a world, those of `measureSettings` and
/// `worldNeeds`, cancelled.
Result<PairTuning> tunePair(TuneBody& A, TuneBody& B, const TuneOptions& options);
}  // namespace ist
