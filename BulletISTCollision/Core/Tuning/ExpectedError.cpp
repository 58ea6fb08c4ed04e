// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tuning/ExpectedError.h"

#include "BulletISTCollision/Core/Accuracy/OverlapPoses.h"
#include "BulletISTCollision/Core/Force/PressureField.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <string>

namespace ist
{
namespace
{
constexpr double kOverlap = 0.01;
constexpr int kPoses = 60;
constexpr uint64_t kSeed = 1;
constexpr int64_t kFirstSpheres = 1000;
// The force error falls with the number of spheres to the power -0.7 (reference figures: 8 % at 1,000 and 1.7 % at 10,000).
constexpr double kSpheresPerError = -1.0 / 0.7;

/// sigma_F / |F| in a random pose with the given overlap; negative if the drawn rotation allows no such pose.
double errorAt(const InnerSphereTree& tree, double fraction, std::mt19937_64& random, QueryWorkspace& workspace)
{
	const std::optional<Pose> X = poseAtOverlap(tree, tree, fraction, -1, random, workspace);
	if (!X) return -1;
	const OverlapResult result = queryOverlap(tree, tree, *X, workspace);
	const double force = norm(pressureWrench(result.total, {}).force);
	return force > 0 ? overlapError(result, tree, tree, 1).force / force : -1;
}

const char* whatMayHelp(const InnerSphereTree& tree, const BuildOptions& options, bool stuck)
{
	if (!stuck) return "; allow more spheres (BuildOptions::maxSpheres), or accept a larger error";
	if (tree.fill >= options.targetFill)
		return ", which fill the share that was asked for (BuildOptions::targetFill); raise it, or accept a larger error";
	return ", and no more fit; accept a larger error, or lower the minimum radius (BuildOptions::minRadius)";
}
}  // namespace

double expectedForceError(const InnerSphereTree& tree, double fraction, int poses, uint64_t seed)
{
	std::mt19937_64 random(seed);
	QueryWorkspace workspace;
	double sum = 0;
	int count = 0;
	for (int i = 0; i < poses; ++i)
	{
		const double error = errorAt(tree, fraction, random, workspace);
		if (error < 0) continue;
		sum += error * error;
		++count;
	}
	return 2 * count >= poses ? std::sqrt(sum / count) : -1;
}

Result<InnerSphereTree> buildTreeToError(const Mesh& mesh, double error, const BuildOptions& options, BuildTimes* times)
{
	const auto start = std::chrono::steady_clock::now();
	const Result<RepairedMesh> repaired = repairToBuild(mesh, options);
	if (!repaired) return repaired.error();
	const double repairing = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
	Result<InnerSphereTree> tree = buildRepairedToError(mesh, repaired.value(), error, options, times);
	if (times) times->setup += repairing;
	return tree;
}

Result<InnerSphereTree> buildRepairedToError(
	const Mesh& mesh, const RepairedMesh& repaired, double error, const BuildOptions& options, BuildTimes* times)
{
	if (const Result<InstructionSet> chosen = chosenInstructionSet(); !chosen) return chosen.error();
	BuildOptions attempt = options;
	attempt.maxSpheres = std::min(kFirstSpheres, options.maxSpheres);
	for (;;)
	{
		Result<InnerSphereTree> tree = buildRepaired(mesh, repaired, attempt, times);
		if (!tree) return tree;
		const double reached = expectedForceError(tree.value(), kOverlap, kPoses, kSeed);
		if (reached < 0)
			return Error{"the body cannot overlap itself by 1 % of its volume in most poses, so its force error cannot be estimated; call "
						 "buildTree() with BuildOptions::maxSpheres instead"};
		if (reached <= error) return tree;
		const bool stuck = int64_t(tree.value().spheres.size()) < attempt.maxSpheres && !leavesBecomeSmaller(attempt);
		if (stuck || attempt.maxSpheres >= options.maxSpheres)
			return Error{"a force error of " + std::to_string(error) + " is out of reach: " + std::to_string(tree.value().spheres.size()) +
				" spheres give " + std::to_string(reached) + whatMayHelp(tree.value(), options, stuck)};
		// Slightly more than the estimate, so that the next attempt is likely the last.
		const double factor = std::clamp(1.2 * std::pow(error / reached, kSpheresPerError), 1.3, 100.0);
		attempt.maxSpheres = std::min(options.maxSpheres, int64_t(double(attempt.maxSpheres) * factor));
	}
}
}  // namespace ist
