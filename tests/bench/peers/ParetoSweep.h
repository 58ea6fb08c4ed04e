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
/// What is swept.
struct SweepSettings
{
	std::vector<std::pair<std::string, std::string>> pairs;  ///< names of `meshNamed`
	std::vector<int> spheres;
	std::vector<int> manySpheres;  ///< so many that they take minutes: for the first pair only
	TruthSettings truth;
	std::vector<double> errors = {0.02, 0.05, 0.1, 0.2};  ///< accepted, by the dial
	std::vector<int> budgets = {100, 1000};               ///< of pairs
	int passes = 5;
	int paths = 3;  ///< poses of each overlap through which B is led
	bool peers = true;
	std::string folder;  ///< keeps truth and trees from run to run; empty: nowhere
};

/// A tree and what it took.
struct SweptBody
{
	ist::InnerSphereTree tree;
	double buildSeconds = 0;
	double bytes = 0;  ///< of the asset and the levels
};

/// One estimator on one pair of bodies at one overlap. Errors are against quadrature; of the force, of its true size.
struct ParetoRow
{
	std::string pair, estimator;  ///< "level 3", "budget 100", "dial 5 %", "paper", "closed form", or the name of another library
	double overlap = 0;
	double depthOverGap = 0;     ///< mean depth of the overlap, V over the area vector, in sums of both bodies' gaps; as the leaves see it
	int spheres = 0, poses = 0;  ///< no spheres: another library
	double buildSeconds = 0, bytes = 0;
	double p50 = 0, p99 = 0, p999 = 0;  ///< [us]
	double pairs = 0;
	double volumeBias = 0, volumeSpread = 0;       ///< mean and standard deviation of V / V_true - 1
	double forceSize = 0, force = 0, force95 = 0;  ///< rms of |F| / |F_true| - 1; rms and 95th percentile of |F - F_true| / |F_true|
	double direction = 0;                          ///< median [deg]
	double torque = 0;                             ///< rms, of |F_true| times the smaller body's size
	double point = 0;                              ///< rms distance of the centre of the overlap, of the smaller body's size
	// On paths through some of the poses (PathQuality), the worst of them.
	double noise = 0, loopWork = 0, restDepth = 0;
	double inFloat = 0;       ///< what floats change in the force, 1 km from the origin, of the force
	double explicitK = 0;     ///< largest k [Pa/m] at which explicit steps of 1 ms of 1 kg do not diverge
	double implicitStep = 0;  ///< longest implicit step [s] that keeps 95 % of the speed of a body whose weight presses it in this deep
	double zWidth = 0;  ///< largest wall [N/m] that stays passive at 1 kHz with 5 N s/m, when the query takes its p99.9: b / (T/2 + t)
};

/// How the dial fared on one pair: over all overlaps together.
struct ErrorBoundRow
{
	std::string pair;
	double error = 0;  ///< accepted
	int spheres = 0, poses = 0;
	double held =
		0;  ///< share of poses whose true error is below what was promised: `error`, or what the answer says where the leaves fall short
	double kept = 0;                          ///< share of poses where `error` was promised
	double ofErrorBound = 0;                  ///< median of the true error over what the answer promised
	double worst = 0, largestErrorBound = 1;  ///< of the pose where that is largest: true error, and what was promised
	double ofLeaves = 0;                      ///< pairs over those of the leaves
	double ofFixed = 0;  ///< pairs of all looks over those of the cheapest fixed level whose true error is below `error` in 95 % of poses;
						 ///< 0: there is none
};

struct Sweep
{
	std::vector<ParetoRow> rows;
	std::vector<ErrorBoundRow> errorBounds;
};

/// Builds, asks and compares, into `sweep`. Progress goes to stderr. `keep` is called whenever a pair of bodies is done with a number of
/// spheres; where it returns false the sweep ends, and returns false.
bool runSweep(const SweepSettings& settings, Sweep& sweep, const std::function<bool()>& keep);
}  // namespace bench
