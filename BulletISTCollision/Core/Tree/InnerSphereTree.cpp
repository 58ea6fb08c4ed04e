// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

#include "BulletISTCollision/Core/Surface/SurfaceLimits.h"
#include "BulletISTCollision/Core/Tree/TreeLimits.h"

#include <cmath>

namespace ist
{
namespace
{
static_assert(kFarthest == kMostReach);

bool isLength(double value) { return std::isfinite(value) && value >= 0; }
}  // namespace

std::string InnerSphereTree::validate() const
{
	if (!isFinite(origin)) return "origin not finite";
	if (!std::isfinite(volume) || !(volume > 0)) return "volume not positive";
	for (int i = 0; i < 3; ++i)
		if (!isFinite(inertia.row(i))) return "inertia not finite";
	if (!isLength(area)) return "area not finite";
	if (!isLength(meanGap) || !isLength(maxGap) || !isLength(resolution)) return "gap not finite";
	if (!isLength(sagitta)) return "sagitta not finite";
	if (!isLength(uncoveredArea) || !isLength(fill)) return "fill or uncovered share not finite";
	if (!std::all_of(calibration.begin(), calibration.end(), isLength)) return "calibration not finite";
	const struct
	{
		const char* name;
		const BallTree& tree;
	} trees[] = {{"law", law}, {"cells", cells}, {"inner", inner}};
	for (const auto& [name, tree] : trees)
	{
		if (tree.empty()) return std::string(name) + " tree: empty";
		if (tree.ellipsoids.empty() != (&tree == &inner)) return std::string(name) + " tree: not of its kind of balls";
		const std::string problem = tree.validate();
		if (!problem.empty()) return std::string(name) + " tree: " + problem;
	}
	if (!surface.empty())
		if (const std::string problem = surface.validate(); !problem.empty()) return "surface: " + problem;
	for (size_t i = 0; i < levels.size(); ++i)
	{
		const std::string problem = levels[i].empty() ? "empty" : levels[i].validate();
		if (!problem.empty()) return "level " + std::to_string(i + 1) + ": " + problem;
	}
	return {};
}
}  // namespace ist
