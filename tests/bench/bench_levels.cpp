// SPDX-License-Identifier: Zlib
// Measures the force error of pair budgets, bunny against bunny. The reference is a tree with many more leaves at the same poses.
// Usage: bench_levels FINE.ist TRUTH.ist [POSES]
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"
#include "tests/bench/bodies/BenchPoses.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

using namespace ist;

namespace
{
constexpr PressurePair kPair{1, 0.5, 0.5};

struct Errors
{
	double squares = 0, microseconds = 0, pairs = 0, level = 0;
	std::vector<double> overSigma;  ///< |error| over the reported sigma of the force
	int over = 0, refused = 0;      ///< number of exceeded budgets; number of queries without an answer
};

Errors measure(const InnerSphereTree& body, const InnerSphereTree& truth, const std::vector<Pose>& poses, double share)
{
	QueryWorkspace workspace;
	Errors errors;
	QueryOptions options;
	options.patches = false;
	for (const Pose& X : poses)
	{
		const Vec3 exact = pressureWrench(queryOverlap(truth, truth, X, workspace, options).total, kPair).force;
		QueryOptions limited = options;
		const int64_t all = queryOverlap(body, body, X, workspace, options).total.pairs;
		if (share < 1) limited.maxPairs = int64_t(share * double(all));
		const auto start = std::chrono::steady_clock::now();
		const OverlapResult r = queryOverlap(body, body, X, workspace, limited);
		errors.microseconds += std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count() /
			double(poses.size());
		if (r.status != QueryStatus::Ok)
		{
			++errors.refused;
			continue;
		}
		if (share < 1 && r.total.pairs > limited.maxPairs) ++errors.over;
		const double error = norm(pressureWrench(r.total, kPair).force - exact);
		errors.squares += squaredNorm(exact) > 0 ? error * error / squaredNorm(exact) : 0;
		errors.overSigma.push_back(error / overlapError(r, body, body, kPair.stiffness).force);
		errors.pairs += double(r.total.pairs) / double(poses.size());
		errors.level += r.level / double(poses.size());
	}
	return errors;
}
}  // namespace

int main(int argc, char** argv)
{
	if (argc < 3)
	{
		std::fprintf(stderr, "usage: bench_levels FINE.ist TRUTH.ist [POSES=20]\n");
		return 2;
	}
	Result<InnerSphereTree> body = loadAsset(argv[1]), truth = loadAsset(argv[2]);
	if (!body || !truth)
	{
		std::fprintf(stderr, "bench_levels: %s\n", (body ? truth : body).error().message.c_str());
		return 1;
	}
	const auto start = std::chrono::steady_clock::now();
	body.value().levels = buildLevels(body.value().law);
	const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
	size_t all = body.value().law.memory();
	for (const BallTree& level : body.value().levels) all += level.memory();
	const double leaves = body.value().law.ballCount();
	std::printf("%zu levels built in %.3f s; bytes a leaf: %.1f, with all levels %.1f\n", body.value().levels.size(), seconds,
		double(body.value().law.memory()) / leaves, double(all) / leaves);
	std::printf("%8s %8s %9s %7s %9s %9s %9s %10s %6s %8s\n", "overlap", "budget", "pairs", "level", "us", "force rms", "x full",
		"p95/sigma", "over", "refused");
	for (const double overlap : {0.001, 0.01, 0.1, 0.5})
	{
		const std::vector<Pose> poses = bench::posesAtOverlap(body.value(), body.value(), overlap, argc > 3 ? std::atoi(argv[3]) : 20);
		double full = 0;
		for (const double share : {1.0, 0.5, 0.25, 0.125, 0.0625, 0.015})
		{
			Errors e = measure(body.value(), truth.value(), poses, share);
			const size_t count = std::max<size_t>(1, e.overSigma.size());
			const double rms = std::sqrt(e.squares / double(count));
			if (share == 1) full = rms;
			std::sort(e.overSigma.begin(), e.overSigma.end());
			std::printf("%8g %8.4g %9.0f %7.2f %9.1f %8.2f%% %9.2f %10.2f %6d %8d\n", overlap, share, e.pairs, e.level, e.microseconds,
				100 * rms, rms / full, e.overSigma.empty() ? 0 : e.overSigma[e.overSigma.size() * 95 / 100], e.over, e.refused);
		}
	}
	return 0;
}
