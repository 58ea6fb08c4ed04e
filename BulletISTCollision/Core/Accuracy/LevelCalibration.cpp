// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"

#include "BulletISTCollision/Core/Accuracy/OverlapPoses.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ist
{
namespace
{
constexpr int kPosesPerOverlap = 12;
/// Approximate number of balls of the level with which poses of a given overlap are searched.
constexpr uint32_t kSearchBalls = 500;
constexpr double kHeld = 0.95;
/// Limits of the coefficients. Below kLeast other errors dominate. A coefficient above kMost was never needed; it is measured
/// where a level's balls are thicker than the body.
constexpr double kLeast = 0.15, kMost = 0.4;
constexpr uint64_t kSeed = 1;
/// The queries only add up, so they need no list of pairs. A list would take 20 MB per thread.
constexpr QueryCapacity kNoList{.pairs = 1, .patches = 1};
/// Coefficients are multiples of 1 / kSteps, because further digits are meaningless.
constexpr double kSteps = 1000;

Vec3 forceAt(const InnerSphereTree& tree, const Pose& X, int level, QueryWorkspace& workspace, double& volume)
{
	QueryOptions options;
	options.model = Model::Leaf;
	options.level = level;
	options.stiffness = options.patches = false;
	const OverlapResult result = queryOverlap(tree, tree, X, workspace, options);
	volume = result.total.volume;
	return pressureWrench(result.total, {}).force;
}

/// The coefficient that each level would have needed in this pose, negative where it has no overlap. Level i of the body is
/// level 2 (i + 1) of the pair.
std::vector<double> compareLevels(const InnerSphereTree& tree, const Pose& X, QueryWorkspace& workspace)
{
	std::vector<double> needed(tree.levels.size(), -1);
	double volume = 0;
	const Vec3 force = forceAt(tree, X, 0, workspace, volume);
	for (size_t i = 0; i < tree.levels.size(); ++i)
	{
		const Vec3 coarse = forceAt(tree, X, int(2 * (i + 1)), workspace, volume);
		if (!(volume > 0)) continue;
		const double balls = double(tree.levels[i].ballCount()) * volume / tree.volume;
		needed[i] = norm(coarse - force) / (volume * std::sqrt(2 / balls));
	}
	return needed;
}

/// A pose in which the body is measured against itself.
struct Trial
{
	double overlap;
	Departure departure;
	std::vector<double> needed;  ///< coefficient that each level needs; empty if there is no such pose
};

std::vector<Trial> drawTrials()
{
	std::mt19937_64 random(kSeed);
	std::vector<Trial> trials;
	for (const double overlap : kOverlapsOfContact)
		for (int i = 0; i < kPosesPerOverlap; ++i) trials.push_back({overlap, randomDeparture(random), {}});
	return trials;
}

void measure(const InnerSphereTree& tree, Trial& trial, QueryWorkspace& workspace)
{
	size_t search = 0;
	while (search + 1 < tree.levels.size() && tree.levels[search + 1].ballCount() >= kSearchBalls) ++search;
	const std::optional<Pose> X = poseAtOverlap(tree, tree, trial.overlap, int(2 * (search + 1)), trial.departure, workspace);
	if (X) trial.needed = compareLevels(tree, *X, workspace);
}

double coefficientOf(std::vector<double>& needed)
{
	if (needed.empty()) return kMost;
	const auto at = needed.begin() + ptrdiff_t(kHeld * double(needed.size() - 1));
	std::nth_element(needed.begin(), at, needed.end());
	return std::clamp(std::round(*at * kSteps) / kSteps, kLeast, kMost);
}
}  // namespace

std::vector<double> measuredCalibration(const InnerSphereTree& tree, [[maybe_unused]] int threads)
{
	if (tree.levels.empty()) return {kMost};
	std::vector<Trial> trials = drawTrials();
#pragma omp parallel num_threads(threads)
	{
		// The portable instruction set makes the result independent of the machine. The loop runs backwards, because the deepest poses
		// come last and take longest.
		QueryWorkspace workspace(kNoList, InstructionSet::Portable);
#pragma omp for schedule(dynamic, 1)
		for (std::ptrdiff_t i = std::ptrdiff_t(trials.size()) - 1; i >= 0; --i) measure(tree, trials[size_t(i)], workspace);
	}
	std::vector<double> coefficients(1);
	for (size_t level = 0; level < tree.levels.size(); ++level)
	{
		std::vector<double> needed;
		for (const Trial& trial : trials)
			if (!trial.needed.empty() && trial.needed[level] >= 0) needed.push_back(trial.needed[level]);
		coefficients.push_back(coefficientOf(needed));
	}
	coefficients[0] = coefficients[1];
	return coefficients;
}

bool hasLevels(const InnerSphereTree& tree) { return tree.calibration.size() == tree.levels.size() + 1; }

void addLevels(InnerSphereTree& tree, int threads)
{
	if (tree.levels.empty()) tree.levels = buildLevels(tree.law, threads);
	if (!hasLevels(tree)) tree.calibration = measuredCalibration(tree, threads);
}
}  // namespace ist
