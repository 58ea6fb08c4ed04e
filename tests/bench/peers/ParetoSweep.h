// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "tests/bench/bodies/TruePoses.h"

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace bench
{
/// Parameters of a sweep.
struct SweepSettings
{
	std::vector<std::pair<std::string, std::string>> pairs;  ///< pairs of names of `meshNamed`
	std::vector<int> spheres;
	std::vector<int> manySpheres;  ///< numbers that take minutes: for the first pair only
	TruthSettings truth;
	std::vector<double> errors = {0.02, 0.05, 0.1, 0.2};  ///< tolerances to query with
	std::vector<int> budgets = {100, 1000};               ///< pair budgets to query with
	int passes = 5;
	int paths = 3;  ///< number of poses of each overlap through which B is moved
	bool peers = true;
	std::string folder;  ///< folder that keeps references and trees from run to run; empty: none
};

/// A tree and the cost of making it.
struct SweptBody
{
	ist::InnerSphereTree tree;
	double buildSeconds = 0;
	double bytes = 0;  ///< size of the asset and the levels
};

/// Results of one estimator on one pair of bodies at one overlap. Errors are against quadrature; those of the force are relative to its
/// true size.
struct ParetoRow
{
	std::string pair, estimator;  ///< "level 3", "budget 100", "dial 5 %", "paper", "closed form", or the name of another library
	double overlap = 0;
	double depthOverGap = 0;     ///< mean depth of the overlap (V over the area vector, from the leaves) over the sum of both bodies' gaps
	int spheres = 0, poses = 0;  ///< no spheres: another library
	double buildSeconds = 0, bytes = 0;
	double p50 = 0, p99 = 0, p999 = 0;  ///< quantiles of the query time [us]
	double pairs = 0;
	double volumeBias = 0, volumeSpread = 0;       ///< mean and standard deviation of V / V_true - 1
	double forceSize = 0, force = 0, force95 = 0;  ///< rms of |F| / |F_true| - 1; rms and 95th percentile of |F - F_true| / |F_true|
	double direction = 0;                          ///< median error of the direction [deg]
	double torque = 0;                             ///< rms, relative to |F_true| times the smaller body's size
	double point = 0;                              ///< rms distance of the centre of the overlap, relative to the smaller body's size
	// These are the worst values on paths through some of the poses (PathQuality).
	double noise = 0, loopWork = 0, restDepth = 0;
	double inFloat = 0;    ///< change of the force by floats at 1 km from the origin, relative to the force
	double explicitK = 0;  ///< largest k [Pa/m] at which explicit steps of 1 ms of 1 kg do not diverge
	/// Longest implicit step [s] that keeps 95 % of the speed of a body whose weight presses it to this depth.
	double implicitStep = 0;
	double zWidth = 0;  ///< largest wall [N/m] that stays passive at 1 kHz with 5 N s/m, if the query takes its p99.9: b / (T/2 + t)
};

/// Results of queries with a tolerance on one pair, over all overlaps together.
struct ErrorBoundRow
{
	std::string pair;
	double error = 0;  ///< tolerance
	int spheres = 0, poses = 0;
	/// Share of poses whose true error is below the stated bound: `error`, or the bound of the answer where the leaves are not accurate
	/// enough.
	double held = 0;
	double kept = 0;                          ///< share of poses whose error bound was within `error`
	double ofErrorBound = 0;                  ///< median of the true error over the stated bound
	double worst = 0, largestErrorBound = 1;  ///< true error and stated bound, in the pose where their ratio is largest
	double ofLeaves = 0;                      ///< number of pairs over that of the leaves
	/// Pairs of all traversals over those of the cheapest fixed level whose true error is below `error` in 95 % of poses; 0: there is
	/// no such level.
	double ofFixed = 0;
};

struct Sweep
{
	std::vector<ParetoRow> rows;
	std::vector<ErrorBoundRow> errorBounds;
};

/// Builds, queries and compares, and adds the results to `sweep`. Progress goes to stderr. `keep` is called when a pair of bodies is
/// done with a number of spheres. If it returns false, the sweep ends and returns false.
bool runSweep(const SweepSettings& settings, Sweep& sweep, const std::function<bool()>& keep);
}  // namespace bench
