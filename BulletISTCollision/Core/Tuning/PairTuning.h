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
/// One of the two bodies: a tree, or a mesh from which trees are built.
struct TuneBody
{
	std::string name;  ///< begins messages about its mesh; may be empty
	std::optional<Mesh> mesh;
	InnerSphereTree tree;  ///< for a mesh, the tree that was built last; after tuning, with levels
};

struct TuneOptions
{
	double error = 0.05;         ///< force tolerance between 0.1 and 20 % overlap, above 0 and at most 1
	int64_t maxSpheres = 30000;  ///< limit for the tree of a mesh
	WorldSetup world;            ///< if it has neither stiffness nor mass, no advice on the world is given
	Progress progress;           ///< stages of `buildTree`, and "tune"; may be empty
};

struct PairTuning
{
	/// The cheapest fixed level whose error bound meets the tolerance. If none does, it is the one with the smallest error bound.
	TuneSetting best;
	bool kept = false;                      ///< true if its error bound meets the tolerance
	size_t spheresA = 0, spheresB = 0;      ///< numbers of spheres of its trees
	std::vector<TuneSetting> alternatives;  ///< all levels of all trees that were measured
	std::optional<TimeStepAdvice> world;
};

/// Finds the cheapest setting of two bodies (which may be the same) whose error bound meets a force tolerance. The settings are the
/// levels of the trees; for a mesh, trees of 1,000, 3,000, 9,000 ... spheres are built until one meets it. The result depends only on the
/// two bodies, except for the times and the choices that follow from them. Takes a fraction of a second plus the time of the builds.
/// Errors: a mesh that cannot be built, an incomplete world, the errors of `measureSettings` and `timeStepAdvice`, cancelled.
Result<PairTuning> tunePair(TuneBody& A, TuneBody& B, const TuneOptions& options);
}  // namespace ist
