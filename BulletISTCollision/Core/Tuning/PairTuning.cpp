// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tuning/PairTuning.h"

#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"

#include <algorithm>

namespace ist
{
namespace
{
constexpr int64_t kFirstSpheres = 1000, kSpheresStep = 3;

/// Prepares the tree of a body, with levels; for a mesh, a tree with this number of spheres is built. Returns an error if that fails.
std::optional<Error> prepare(TuneBody& body, int64_t spheres, const Progress& progress)
{
	if (body.mesh)
	{
		BuildOptions options;
		options.maxSpheres = spheres;
		options.progress = progress;
		Result<InnerSphereTree> tree = buildTree(*body.mesh, options);
		if (!tree) return Error{(body.name.empty() ? "" : body.name + ": ") + tree.error().message, tree.error().cancelled};
		body.tree = std::move(tree).value();
	}
	addLevels(body.tree);
	return std::nullopt;
}

/// The cheapest fixed level that meets the error, or else the one with the smallest error. The last setting, which chooses a level in
/// each pose, is not considered.
const TuneSetting& bestOf(const std::vector<TuneSetting>& settings, double error)
{
	const auto keeps = [&](const TuneSetting& s) { return s.error <= error; };
	const auto better = [&](const TuneSetting& a, const TuneSetting& b) {
		return keeps(a) != keeps(b) ? keeps(a) : keeps(a) ? a.microseconds < b.microseconds : a.error < b.error;
	};
	return *std::min_element(settings.begin(), settings.end() - 1, better);
}

/// Adds the settings of trees with at most this number of spheres.
Result<TuneSettings> tryTrees(TuneBody& A, TuneBody& B, int64_t spheres, const TuneOptions& options, PairTuning& tuning)
{
	if (std::optional<Error> problem = prepare(A, spheres, options.progress)) return *problem;
	if (&A != &B)
		if (std::optional<Error> problem = prepare(B, spheres, options.progress)) return *problem;
	Result<TuneSettings> found = measureSettings(A.tree, B.tree, options.error, options.progress);
	if (!found) return found;
	const std::vector<TuneSetting>& settings = found.value().settings;
	tuning.best = bestOf(settings, options.error);
	tuning.kept = tuning.best.error <= options.error;
	tuning.spheresA = A.tree.spheres.size();
	tuning.spheresB = B.tree.spheres.size();
	tuning.alternatives.insert(tuning.alternatives.end(), settings.begin(), settings.end());
	return found;
}
}  // namespace

Result<PairTuning> tunePair(TuneBody& A, TuneBody& B, const TuneOptions& options)
{
	const bool asksForWorld = options.world.stiffness || options.world.mass, builds = A.mesh || B.mesh;
	if (asksForWorld)
		if (const std::optional<Error> problem = problemOf(options.world)) return *problem;
	PairTuning tuning;
	for (int64_t spheres = std::min(kFirstSpheres, options.maxSpheres);; spheres = std::min(kSpheresStep * spheres, options.maxSpheres))
	{
		const Result<TuneSettings> found = tryTrees(A, B, spheres, options, tuning);
		if (!found) return found.error();
		if (!tuning.kept && builds && spheres < options.maxSpheres) continue;
		if (!asksForWorld) return tuning;
		const Result<TimeStepAdvice> needs = timeStepAdvice(options.world, A.tree, B.tree, found.value().contacts, options.error);
		if (!needs) return needs.error();
		tuning.world = needs.value();
		return tuning;
	}
}
}  // namespace ist
