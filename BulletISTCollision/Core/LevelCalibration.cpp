// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/LevelCalibration.h"

#include "BulletISTCollision/Core/OverlapPoses.h"
#include "BulletISTCollision/Core/PressureField.h"
#include "BulletISTCollision/Core/TreeLevels.h"

#include <algorithm>
#include <cmath>

namespace ist
{
namespace
{
constexpr int kPosesPerOverlap = 12;
/// Overlaps are looked for at a level of about so many balls.
constexpr uint32_t kSearchBalls = 500;
constexpr double kHeld = 0.95;
/// Below, what else errs dominates; above, it was never needed: there a level's balls are thicker than the body.
constexpr double kLeast = 0.15, kMost = 0.4;
constexpr uint64_t kSeed = 1;
/// Coefficients are multiples of 1 over this: more of their digits say nothing.
constexpr double kSteps = 1000;

Vec3 forceAt(const InnerSphereTree& tree, const Pose& X, int level, QueryWorkspace& workspace, double& volume)
{
	QueryOptions options;
	options.level = level;
	options.stiffness = options.patches = false;
	const OverlapResult result = queryOverlap(tree, tree, X, workspace, options);
	volume = result.total.volume;
	return pressureWrench(result.total, {}).force;
}

/// Appends the coefficient that each level would have needed in this pose. Level i of the body is level 2 i of the pair.
void compareLevels(const InnerSphereTree& tree, const Pose& X, QueryWorkspace& workspace, std::vector<std::vector<double>>& needed)
{
	double volume = 0;
	const Vec3 force = forceAt(tree, X, 0, workspace, volume);
	for (size_t i = 0; i < tree.levels.size(); ++i)
	{
		const Vec3 coarse = forceAt(tree, X, int(2 * (i + 1)), workspace, volume);
		if (!(volume > 0)) continue;
		const double balls = double(tree.levels[i].ballCount()) * volume / tree.volume;
		needed[i].push_back(norm(coarse - force) / (volume * std::sqrt(2 / balls)));
	}
}

double coefficientOf(std::vector<double>& needed)
{
	if (needed.empty()) return kMost;
	const auto at = needed.begin() + ptrdiff_t(kHeld * double(needed.size() - 1));
	std::nth_element(needed.begin(), at, needed.end());
	return std::clamp(std::round(*at * kSteps) / kSteps, kLeast, kMost);
}
}  // namespace

std::vector<double> measuredCalibration(const InnerSphereTree& tree)
{
	if (tree.levels.empty()) return {kMost};
	size_t search = 0;
	while (search + 1 < tree.levels.size() && tree.levels[search + 1].ballCount() >= kSearchBalls) ++search;
	std::mt19937_64 random(kSeed);
	QueryWorkspace workspace({}, InstructionSet::Portable);  // the same whatever machine builds
	std::vector<std::vector<double>> needed(tree.levels.size());
	for (const double overlap : kOverlapsOfContact)
		for (int i = 0; i < kPosesPerOverlap; ++i)
			if (const std::optional<Pose> X = poseAtOverlap(tree, tree, overlap, int(2 * (search + 1)), random, workspace)) compareLevels(tree, *X, workspace, needed);
	std::vector<double> coefficients(1);
	for (std::vector<double>& level : needed) coefficients.push_back(coefficientOf(level));
	coefficients[0] = coefficients[1];
	return coefficients;
}

bool hasLevels(const InnerSphereTree& tree) { return tree.calibration.size() == tree.levels.size() + 1; }

void addLevels(InnerSphereTree& tree)
{
	if (tree.levels.empty()) tree.levels = buildLevels(tree.law);
	if (!hasLevels(tree)) tree.calibration = measuredCalibration(tree);
}
}  // namespace ist
