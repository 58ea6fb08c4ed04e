// SPDX-License-Identifier: Zlib
// Prints the goals of the query beside the measured values, bunny against bunny, one per row: smallest times of several visits in
// shuffled order, and ratios within this process. It makes the bodies that it needs in FOLDER. Motion, threads, levels and instructions
// have their own programs: bench_motion, bench_threads, bench_levels, query_instructions.sh. Usage: bench_goals FOLDER [MESH]
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"
#include "tests/bench/bodies/BenchPoses.h"
#include "tests/bench/bodies/NaiveSphereTree.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <numeric>
#include <random>
#include <string>

using namespace ist;

namespace
{
constexpr int kPoses = 10, kVisits = 8;
const int kSpheres[] = {1000, 5000, 10000, 100000};
const double kOverlaps[] = {0.001, 0.01, 0.1, 0.5};

void row(const char* what, const char* goal, const char* format, auto... values)
{
	char text[160];
	std::snprintf(text, sizeof text, format, values...);
	std::printf("%-72s | %-28s | %s\n", what, goal, text);
	std::fflush(stdout);
}

double median(std::vector<double> values)
{
	std::sort(values.begin(), values.end());
	return values[values.size() / 2];
}

/// Mean over the poses of the smallest time [us].
double leastTime(size_t poses, int visits, const std::function<void(size_t)>& query)
{
	std::vector<double> least(poses, 1e300);
	std::vector<size_t> order(poses);
	std::iota(order.begin(), order.end(), size_t(0));
	std::mt19937 random(2);
	for (int visit = 0; visit <= visits; ++visit)
	{
		std::shuffle(order.begin(), order.end(), random);
		for (const size_t i : order)
		{
			const auto start = std::chrono::steady_clock::now();
			query(i);
			const double us = std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
			least[i] = std::min(least[i], us);
		}
	}
	return std::accumulate(least.begin(), least.end(), 0.0) / double(poses);
}

QueryOptions paperMode()
{
	QueryOptions o;
	o.model = Model::Inner;
	o.stiffness = o.patches = false;
	return o;
}
QueryOptions lawMode(bool stiffness)
{
	QueryOptions o;
	o.stiffness = stiffness;
	o.patches = false;
	return o;
}

struct Cost
{
	double us = 0, pairs = 0;
	double perPair() const { return 1e3 * us / pairs; }
};

Cost costOf(const InnerSphereTree& body, const std::vector<Pose>& poses, const QueryOptions& options, QueryWorkspace& workspace)
{
	Cost cost;
	for (const Pose& X : poses) cost.pairs += double(queryOverlap(body, body, X, workspace, options).total.pairs) / double(poses.size());
	cost.us = leastTime(poses.size(), kVisits, [&](size_t i) { queryOverlap(body, body, poses[i], workspace, options); });
	return cost;
}

Cost costOfNaive(const InnerSphereTree& body, const std::vector<Pose>& poses)
{
	const bench::NaiveSphereTree tree(body.inner);
	const auto ask = [&](size_t i) {
		return bench::NaiveSphereTree::query(tree, tree, {poses[i].rotation, poses[i] * body.origin - body.origin});
	};
	Cost cost;
	for (size_t i = 0; i < poses.size(); ++i) cost.pairs += double(ask(i).pairs) / double(poses.size());
	volatile double keep = 0;
	cost.us = leastTime(poses.size(), kVisits, [&](size_t i) { keep = ask(i).volume; });
	return cost;
}

struct Body
{
	int spheres;
	InnerSphereTree tree;
	std::vector<Pose> poses[4];
	Cost naive[4], paper[4], law[4], stiff[4];
};

Result<InnerSphereTree> load(const std::string& folder, const std::string& mesh, int spheres)
{
	const std::string path = folder + "/bunny-" + std::to_string(spheres) + ".ist";
	if (Result<InnerSphereTree> cached = loadAsset(path)) return cached;
	Result<Mesh> triangles = importMesh(mesh);
	if (!triangles) return triangles.error();
	BuildOptions options;
	options.surface = false;  // contact of leaves
	options.maxSpheres = spheres;
	Result<InnerSphereTree> built = buildTree(triangles.value(), options);
	if (!built) return built;
	if (const Result<size_t> saved = saveAsset(built.value(), path); !saved) return saved.error();
	return built;
}

void ratiosToNaive(const std::vector<Body>& bodies)
{
	std::vector<double> ratios, naive;
	for (const Body& body : bodies)
		for (int o = 0; o < 4; ++o)
		{
			if (body.spheres < 5000) continue;
			ratios.push_back(body.naive[o].us / body.paper[o].us);
			if (body.naive[o].pairs >= 500) naive.push_back(body.naive[o].perPair());
		}
	row("paper mode, times faster than the naive reference, median; least", "12; 10 (v4), 8; 7 (v3)", "%.1f; %.1f", median(ratios),
		*std::min_element(ratios.begin(), ratios.end()));
	row("naive reference, ns a pair from 500 pairs up, most", "230", "%.0f", *std::max_element(naive.begin(), naive.end()));
}

void timesOfPairs(const std::vector<Body>& bodies)
{
	double paper = 0, law = 0, stiffness = 0;
	for (const Body& body : bodies)
		for (int o = 0; o < 4; ++o)
		{
			if (body.paper[o].pairs >= 2000) paper = std::max(paper, body.paper[o].perPair());
			if (body.law[o].pairs < 2000) continue;
			law = std::max(law, body.law[o].perPair());
			stiffness = std::max(stiffness, body.stiff[o].us / body.law[o].us - 1);
		}
	row("ns a pair from 2,000 pairs up, most: paper; law", "14; 18 (v4), 18; 24 (v3)", "%.1f; %.1f", paper, law);
	row("stiffness adds, at most", "40 %", "%.0f %%", 100 * stiffness);
	const Body &small = bodies[2], &large = bodies[3];
	row("100,000 over 10,000 spheres, ns a pair at 10 %: paper; law (goal: 500,000)", "1.4", "%.2f; %.2f",
		large.paper[2].perPair() / small.paper[2].perPair(), large.law[2].perPair() / small.law[2].perPair());
}

void worstCase(const InnerSphereTree& body)
{
	QueryWorkspace workspace;
	const std::vector<Pose> same(1);
	const Cost paper = costOf(body, same, paperMode(), workspace);
	double spheres = 0;
	for (const Sphere& s : body.spheres) spheres += kUnitBall * double(s.r) * s.r * s.r;
	const double volume = queryOverlap(body, body, Pose{}, workspace, paperMode()).total.volume;
	row("100,000 identical in one place, paper: ms; volume over that of the spheres - 1", "4; 1e-6", "%.1f; %.1e", 1e-3 * paper.us,
		volume / spheres - 1);
	const OverlapResult law = queryOverlap(body, body, Pose{}, workspace, lawMode(false));
	row("the same, law: volume over the body's - 1; pairs", "3 %", "%.2f %%; %lld", 100 * (law.total.volume / body.volume - 1),
		static_cast<long long>(law.total.pairs));
}

void instructionSets(const Body& body)
{
	for (const auto& [name, options] : {std::pair{"paper", paperMode()}, std::pair{"law", lawMode(false)}})
	{
		double us[4] = {};
		for (const InstructionSet set : kInstructionSets)
		{
			if (!isAvailable(set)) continue;
			QueryWorkspace workspace({}, set);
			us[int(set)] = costOf(body.tree, body.poses[2], options, workspace).us;
		}
		if (us[1] > 0 && us[2] > 0)
			row((std::string("baseline over v3, 10,000 spheres, 10 %, ") + name).c_str(), "4", "%.2f (portable %.2f, v4 %.2f)",
				us[1] / us[2], us[0] / us[2], us[3] / us[2]);
	}
}

void memory(const InnerSphereTree& body)
{
	size_t law = body.law.memory();
	for (const BallTree& level : buildLevels(body.law)) law += level.memory();
	row("bytes a leaf, law tree with all levels; a sphere, inner tree", "96; 70", "%.0f; %.0f", double(law) / body.law.ballCount(),
		double(body.inner.memory()) / body.inner.ballCount());
}
}  // namespace

int main(int argc, char** argv)
{
	const Result<InstructionSet> set = chosenInstructionSet();
	if (argc < 2 || !set)
	{
		std::fprintf(stderr, "%s\n", set ? "usage: bench_goals FOLDER [MESH=bunny.obj of glmark2]" : set.error().message.c_str());
		return 2;
	}
	std::vector<Body> bodies;
	QueryWorkspace workspace;
	for (const int spheres : kSpheres)
	{
		Result<InnerSphereTree> tree = load(argv[1], argc > 2 ? argv[2] : "/usr/share/glmark2/models/bunny.obj", spheres);
		if (!tree)
		{
			std::fprintf(stderr, "bench_goals: %s\n", tree.error().message.c_str());
			return 1;
		}
		Body& body = bodies.emplace_back(Body{spheres, std::move(tree).value(), {}, {}, {}, {}, {}});
		for (int o = 0; o < 4; ++o)
		{
			body.poses[o] = bench::posesAtOverlap(body.tree, body.tree, kOverlaps[o], kPoses);
			body.naive[o] = costOfNaive(body.tree, body.poses[o]);
			body.paper[o] = costOf(body.tree, body.poses[o], paperMode(), workspace);
			body.law[o] = costOf(body.tree, body.poses[o], lawMode(false), workspace);
			body.stiff[o] = costOf(body.tree, body.poses[o], lawMode(true), workspace);
		}
	}
	std::printf("instruction set %s\n%-72s | %-28s | measured\n", toString(set.value()), "what", "goal");
	ratiosToNaive(bodies);
	// bench_truth prints the error of 1,000 spheres at 1 % overlap.
	row("law with 1,000 spheres at 1 %, times faster than naive with 100,000", "30 (at 5 % force error)", "%.0f",
		bodies[3].naive[1].us / bodies[0].law[1].us);
	timesOfPairs(bodies);
	worstCase(bodies[3].tree);
	instructionSets(bodies[2]);
	memory(bodies[2].tree);
	return 0;
}
