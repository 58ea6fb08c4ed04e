// SPDX-License-Identifier: Zlib
// Compares the instruction sets of this machine on queries of a body with itself: each pose is asked with each set in turn, in shuffled
// order. Times are means over the poses of the least of all visits, and ratios those to the reference set's.
// Usage: bench_sets [--poses N=6] [--visits N=15] [--only MODE]... [--set NAME]... [--reference NAME=v3] TREE OVERLAP...
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
struct Settings
{
	int poses = 6, visits = 15;
	std::vector<std::string> modes, sets;
	std::string reference = "v3", tree;
	std::vector<double> overlaps;
};

struct Mode
{
	const char* name;
	bool ofSurfaces;
	QueryOptions options;
};

std::vector<Mode> modes()
{
	QueryOptions paper, law, full;
	paper.model = Model::Inner;
	paper.stiffness = paper.patches = false;
	law.stiffness = law.patches = false;
	return {{"surface", true, full}, {"paper", false, paper}, {"law", false, law}, {"law+K+patches", false, full}};
}

bool parse(int argc, char** argv, Settings& s)
{
	for (int i = 1; i < argc; ++i)
	{
		const std::string word = argv[i];
		if (word.rfind("--", 0) != 0)
		{
			if (s.tree.empty()) s.tree = word;
			else s.overlaps.push_back(std::atof(argv[i]));
			continue;
		}
		if (i + 1 == argc) return false;
		const char* value = argv[++i];
		if (word == "--poses") s.poses = std::atoi(value);
		else if (word == "--visits") s.visits = std::atoi(value);
		else if (word == "--only") s.modes.push_back(value);
		else if (word == "--set") s.sets.push_back(value);
		else if (word == "--reference") s.reference = value;
		else return false;
	}
	return !s.tree.empty() && !s.overlaps.empty() && s.poses > 0 && s.visits > 0;
}

bool isWanted(const std::vector<std::string>& names, const char* name)
{
	return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

struct Timed
{
	InstructionSet set;
	QueryWorkspace workspace;
	std::vector<double> least;  ///< least time of each pose [us]
	double pairs = 0;           ///< mean over the poses; faces, where surfaces answer

	double mean() const { return std::accumulate(least.begin(), least.end(), 0.0) / double(least.size()); }
};

double ask(const InnerSphereTree& body, const Pose& X, const QueryOptions& options, Timed& timed)
{
	const auto start = std::chrono::steady_clock::now();
	queryOverlap(body, body, X, timed.workspace, options);
	return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

void measure(const InnerSphereTree& body, double overlap, const std::vector<Pose>& poses, const Mode& mode, const Settings& settings)
{
	std::vector<Timed> sets;
	for (const InstructionSet set : kInstructionSets)
		if (isAvailable(set) && isWanted(settings.sets, toString(set)))
			sets.push_back({set, QueryWorkspace({}, set), std::vector<double>(poses.size(), 1e300), 0});
	for (Timed& timed : sets)
		for (const Pose& X : poses)
		{
			const OverlapResult r = queryOverlap(body, body, X, timed.workspace, mode.options);
			timed.pairs += double(mode.ofSurfaces ? int64_t(r.faceCountA + r.faceCountB) : r.total.pairs) / double(poses.size());
		}
	std::vector<size_t> order(poses.size());
	std::iota(order.begin(), order.end(), size_t(0));
	std::mt19937 random(2);
	for (int visit = 0; visit < settings.visits; ++visit)
	{
		std::shuffle(order.begin(), order.end(), random);
		for (const size_t i : order)
			for (Timed& timed : sets) timed.least[i] = std::min(timed.least[i], ask(body, poses[i], mode.options, timed));
	}
	double reference = 0;
	for (const Timed& timed : sets)
		if (settings.reference == toString(timed.set)) reference = timed.mean();
	for (const Timed& timed : sets)
	{
		std::printf("%8g %-14s %-9s %9.0f %10.1f", overlap, mode.name, toString(timed.set), timed.pairs, timed.mean());
		if (reference > 0) std::printf(" %8.2f", timed.mean() / reference);
		std::printf("\n");
	}
}
}  // namespace

int main(int argc, char** argv)
{
	Settings settings;
	if (!parse(argc, argv, settings))
	{
		std::fprintf(stderr,
			"usage: bench_sets [--poses N=6] [--visits N=15] [--only surface|paper|law|law+K+patches]... [--set NAME]...\n"
			"                  [--reference NAME=v3] TREE OVERLAP...\n");
		return 2;
	}
	Result<InnerSphereTree> tree = loadAsset(settings.tree);
	if (!tree)
	{
		std::fprintf(stderr, "bench_sets: %s\n", tree.error().message.c_str());
		return 1;
	}
	InnerSphereTree leaves = tree.value();
	leaves.surface = {};
	std::printf("%8s %-14s %-9s %9s %10s %8s\n", "overlap", "mode", "set", "pairs", "us", "ratio");
	for (const double overlap : settings.overlaps)
	{
		const std::vector<Pose> poses = bench::posesAtOverlap(tree.value(), tree.value(), overlap, settings.poses);
		for (const Mode& mode : modes())
			if (isWanted(settings.modes, mode.name)) measure(mode.ofSurfaces ? tree.value() : leaves, overlap, poses, mode, settings);
	}
	return 0;
}
