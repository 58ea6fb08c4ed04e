// SPDX-License-Identifier: Zlib
// Shows how close queries come to the limit of their leaf kernels in this binary on this machine, bunny against bunny. Two small trees
// stay in the first-level cache, and all their blocks overlap each other. They show the time of testing one ball against a block where
// nothing meets, including its share of the listing, and the extra time of a pair where all meet. No query with the same counts can be
// faster than
//     limit = (node visits + pairs of blocks + balls against blocks) * time of a test + pairs * time of a pair.
// Opening a node tests one bound against eight, and choosing a block's balls tests one against sixteen. Usage: bench_limit FOLDER
// [SPHERES...] (FOLDER/bunny-N.ist, as bench_goals makes them)
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "tests/bench/bodies/BenchPoses.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <random>
#include <string>
#include <vector>

using namespace ist;

namespace
{
constexpr int kPoses = 10, kVisits = 12;
constexpr int kPeakVisits = 2000;
constexpr double kOverlaps[] = {0.01, 0.1, 0.5};

QueryOptions optionsOf(Model model)
{
	QueryOptions options;
	options.model = model;
	options.stiffness = options.patches = false;
	return options;
}

/// Work of a query, or the mean of several.
struct Work
{
	double us = 0, traversals = 0, pairs = 0;
};

Work workOf(const OverlapResult& r)
{
	return {0, double(r.nodeVisits + r.blockPairs) + double(r.ballTests) / kBlockWidth, double(r.total.pairs)};
}

/// Mean over the poses of the smallest time of several visits in shuffled order.
Work measure(const InnerSphereTree& A, const InnerSphereTree& B, const std::vector<Pose>& poses, Model model, int visits)
{
	const QueryOptions options = optionsOf(model);
	QueryWorkspace workspace;
	std::vector<double> least(poses.size(), 1e300);
	std::vector<size_t> order(poses.size());
	std::iota(order.begin(), order.end(), size_t(0));
	std::mt19937 random(2);
	Work mean;
	for (int visit = 0; visit <= visits; ++visit)
	{
		std::shuffle(order.begin(), order.end(), random);
		for (const size_t i : order)
		{
			const auto start = std::chrono::steady_clock::now();
			const OverlapResult r = queryOverlap(A, B, poses[i], workspace, options);
			least[i] = std::min(least[i], std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
			if (visit > 0) continue;
			const Work work = workOf(r);
			mean.traversals += work.traversals / double(poses.size());
			mean.pairs += work.pairs / double(poses.size());
		}
	}
	mean.us = std::accumulate(least.begin(), least.end(), 0.0) / double(poses.size());
	return mean;
}

/// Sixteen blocks under two nodes. Each block has a ball in sixteen of the places `at`, so all blocks have the same bound.
BallTree layeredTree(const std::vector<Vec3>& at, double radius)
{
	constexpr int kNodes = 2;
	std::vector<Sphere> balls;
	std::vector<StoredEllipsoid> ellipsoids;
	std::vector<uint32_t> index;
	for (const Vec3& p : at)
	{
		const Sphere ball{float(p.x), float(p.y), float(p.z), float(radius)};
		MomentEllipsoid whole = ballOf(ball, uint32_t(balls.size()));
		whole.nz = 0.5f;
		index.push_back(uint32_t(balls.size()));
		balls.push_back(ball);
		ellipsoids.emplace_back(whole);
	}
	std::vector<BallNode> nodes(1 + kNodes);
	for (size_t n = 0; n < nodes.size(); ++n)
		for (uint32_t k = 0; k < BallNode::kWidth; ++k)
		{
			BallNode& node = nodes[n];
			const bool none = n == 0 && k >= kNodes;
			node.x[k] = none ? kFarAway : 0;
			node.y[k] = node.z[k] = 0;
			node.r[k] = none ? 0 : 2;
			node.child[k] = none ? BallNode::kNoChild : n == 0 ? k + 1 : BallNode::kLeafBit | (uint32_t(n - 1) * BallNode::kWidth + k);
		}
	BallTree tree;
	tree.nodes = FrozenArray<BallNode>(std::move(nodes));
	tree.balls = FrozenArray<Sphere>(std::move(balls));
	tree.ellipsoids = FrozenArray<StoredEllipsoid>(std::move(ellipsoids));
	return tree;
}

/// Balls of radius `radius` at places spread over a unit cube, from the seed `seed`.
InnerSphereTree layeredBody(double radius, unsigned seed)
{
	std::mt19937 random(seed);
	std::uniform_real_distribution<double> unit(-0.5, 0.5);
	std::vector<Vec3> at(2 * BallNode::kWidth * kBlockWidth);
	for (Vec3& p : at) p = {unit(random), unit(random), unit(random)};
	InnerSphereTree body;
	body.volume = 1;
	body.law = body.inner = layeredTree(at, radius);
	body.inner.ellipsoids = {};
	return body;
}

/// Best times of the leaf kernels [us].
struct Peak
{
	double look = 0, pair = 0;
	double limit(const Work& work) const { return look * work.traversals + pair * work.pairs; }
};

Peak peakOf(Model model)
{
	const std::vector<Pose> same(1);
	// No balls of the first pair meet; all balls of the second do.
	const Work apart = measure(layeredBody(1e-6, 1), layeredBody(1e-6, 2), same, model, kPeakVisits);
	const Work meeting = measure(layeredBody(1, 1), layeredBody(1, 2), same, model, kPeakVisits);
	const double look = apart.us / apart.traversals;
	std::printf("  %.0f traversals, %.0f pairs in %.1f us; %.0f and %.0f in %.1f us\n", apart.traversals, apart.pairs, apart.us,
		meeting.traversals, meeting.pairs, meeting.us);
	return {look, (meeting.us - look * meeting.traversals) / meeting.pairs};
}

int usage()
{
	std::fprintf(stderr, "usage: bench_limit FOLDER [SPHERES=10000 100000]...\n");
	return 2;
}
}  // namespace

int main(int argc, char** argv)
{
	if (argc < 2) return usage();
	std::vector<int> spheres;
	for (int i = 2; i < argc; ++i)
	{
		spheres.push_back(std::atoi(argv[i]));
		if (spheres.back() <= 0) return usage();
	}
	if (spheres.empty()) spheres = {10000, 100000};
	const Result<InstructionSet> set = chosenInstructionSet();
	if (!set)
	{
		std::fprintf(stderr, "bench_limit: %s\n", set.error().message.c_str());
		return 1;
	}
	for (const Model model : {Model::Inner, Model::Law})
	{
		std::printf("%s, instruction set %s\n", model == Model::Inner ? "paper" : "law", toString(set.value()));
		const Peak peak = peakOf(model);
		std::printf("  a look %.2f ns, a pair %.2f ns\n%9s %8s %9s %9s %9s %9s %7s\n", 1e3 * peak.look, 1e3 * peak.pair, "spheres",
			"overlap", "traversals", "pairs", "limit us", "us", "share");
		for (const int count : spheres)
		{
			const Result<InnerSphereTree> body = loadAsset(std::string(argv[1]) + "/bunny-" + std::to_string(count) + ".ist");
			if (!body)
			{
				std::fprintf(stderr, "bench_limit: %s\n", body.error().message.c_str());
				return 1;
			}
			for (const double overlap : kOverlaps)
			{
				const Work work = measure(
					body.value(), body.value(), bench::posesAtOverlap(body.value(), body.value(), overlap, kPoses), model, kVisits);
				std::printf("%9d %8g %9.0f %9.0f %9.1f %9.1f %7.2f\n", count, overlap, work.traversals, work.pairs, peak.limit(work),
					work.us, peak.limit(work) / work.us);
				std::fflush(stdout);
			}
		}
	}
	return 0;
}
