// SPDX-License-Identifier: Zlib
// Measures time and work of the overlap query, bunny against bunny. Usage: bench_query [--csv FILE] [--poses N] [--visits N] [--cache
// FOLDER] [--mesh FILE] [--only MODE] [--overlap FRACTION] SPHERES...
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "tests/bench/bodies/BenchPoses.h"
#include "tests/bench/bodies/NaiveSphereTree.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <random>
#include <string>
#include <vector>

using namespace ist;

namespace
{
struct Settings
{
	std::string csv, cache = "/tmp", mesh = "/usr/share/glmark2/models/bunny.obj", only;
	int poses = 20, visits = 8;
	std::vector<double> overlaps;
	std::vector<int> spheres;
};

struct Mode
{
	const char* name;
	QueryOptions options;
};

struct Timing
{
	double microseconds = 0;  ///< mean over the poses of the median over the visits
	double least = 0;         ///< mean over the poses of the minimum over the visits; it is closer to the time on an idle machine
	double pairs = 0, volume = 0, nodeVisits = 0, blockPairs = 0, ballTests = 0;  ///< means over the poses
};

Result<InnerSphereTree> body(const Settings& settings, int spheres)
{
	const std::string path = settings.cache + "/bunny-" + std::to_string(spheres) + ".ist";
	if (Result<InnerSphereTree> cached = loadAsset(path)) return cached;
	Result<Mesh> mesh = importMesh(settings.mesh);
	if (!mesh) return mesh.error();
	BuildOptions options;
	options.surface = false;  // contact of leaves
	options.maxSpheres = spheres;
	Result<InnerSphereTree> built = buildTree(mesh.value(), options);
	if (built)
		if (Result<size_t> saved = saveAsset(built.value(), path); !saved) std::fprintf(stderr, "%s\n", saved.error().message.c_str());
	return built;
}

double median(std::vector<double>& values)
{
	std::nth_element(values.begin(), values.begin() + ptrdiff_t(values.size() / 2), values.end());
	return values[values.size() / 2];
}

/// Poses are shuffled anew in each visit: a repeated pose trains the branch predictor and halves the time.
void timePoses(size_t poses, int visits, Timing& timing, const std::function<void(size_t)>& query)
{
	std::vector<std::vector<double>> times(poses);
	std::vector<size_t> order(poses);
	for (size_t i = 0; i < poses; ++i) order[i] = i;
	std::mt19937 random(2);
	for (int visit = 0; visit <= visits; ++visit)
	{
		std::shuffle(order.begin(), order.end(), random);
		for (const size_t i : order)
		{
			const auto start = std::chrono::steady_clock::now();
			query(i);
			const auto stop = std::chrono::steady_clock::now();
			if (visit > 0) times[i].push_back(std::chrono::duration<double, std::micro>(stop - start).count());
		}
	}
	for (std::vector<double>& t : times)
	{
		timing.microseconds += median(t) / double(poses);
		timing.least += *std::min_element(t.begin(), t.end()) / double(poses);
	}
}

Timing measure(const InnerSphereTree& A, const InnerSphereTree& B, const std::vector<Pose>& poses, const Mode& mode, int visits)
{
	QueryWorkspace workspace;
	Timing timing;
	for (const Pose& X : poses)
	{
		const OverlapResult r = queryOverlap(A, B, X, workspace, mode.options);
		if (r.status != QueryStatus::Ok)
		{
			std::fprintf(stderr, "bench_query: %s\n", toString(r.status));
			std::exit(1);
		}
		timing.pairs += double(r.total.pairs) / double(poses.size());
		timing.volume += r.total.volume / double(poses.size());
		timing.nodeVisits += double(r.nodeVisits) / double(poses.size());
		timing.blockPairs += double(r.blockPairs) / double(poses.size());
		timing.ballTests += double(r.ballTests) / double(poses.size());
	}
	timePoses(poses.size(), visits, timing, [&](size_t i) { queryOverlap(A, B, poses[i], workspace, mode.options); });
	return timing;
}

Timing measureNaive(const InnerSphereTree& A, const InnerSphereTree& B, const std::vector<Pose>& poses, int visits)
{
	const bench::NaiveSphereTree a(A.inner), b(B.inner);
	const auto frame = [&](const Pose& X) { return Pose{X.rotation, X * B.origin - A.origin}; };
	Timing timing;
	for (const Pose& X : poses)
	{
		const auto r = bench::NaiveSphereTree::query(a, b, frame(X));
		timing.pairs += double(r.pairs) / double(poses.size());
		timing.volume += r.volume / double(poses.size());
		timing.ballTests += double(r.tests) / double(poses.size());
	}
	volatile double keep = 0;
	timePoses(poses.size(), visits, timing, [&](size_t i) { keep = bench::NaiveSphereTree::query(a, b, frame(poses[i])).volume; });
	return timing;
}

std::vector<Mode> modes()
{
	QueryOptions paper, law, stiff, full;
	paper.model = Model::Inner;
	paper.stiffness = paper.patches = false;
	law.stiffness = law.patches = false;
	stiff.patches = false;
	return {{"paper", paper}, {"law", law}, {"law+K", stiff}, {"law+K+patches", full}};
}

class Table
{
public:
	explicit Table(const std::string& path)
	{
		if (!path.empty()) m_csv.open(path);
		m_csv << "spheres,overlap,mode,pairs,volume,microseconds,ns_per_pair,least_ns_per_pair,times_faster_than_naive,node_visits,block_"
				 "pairs,ball_tests\n";
		std::printf("%8s %8s %-14s %9s %10s %10s %8s %8s %8s %9s %9s %9s\n", "spheres", "overlap", "mode", "pairs", "volume", "us",
			"ns/pair", "least", "x naive", "nodes", "blocks", "tests");
	}
	void row(int spheres, double overlap, const char* mode, const Timing& t, const Timing& naive)
	{
		const double perPair = 1e3 * t.microseconds / t.pairs, leastPerPair = 1e3 * t.least / t.pairs, ratio = naive.least / t.least;
		std::printf("%8d %8g %-14s %9.0f %10.4g %10.2f %8.1f %8.1f %8.1f %9.0f %9.0f %9.0f\n", spheres, overlap, mode, t.pairs, t.volume,
			t.microseconds, perPair, leastPerPair, ratio, t.nodeVisits, t.blockPairs, t.ballTests);
		std::fflush(stdout);
		m_csv << spheres << ',' << overlap << ',' << mode << ',' << t.pairs << ',' << t.volume << ',' << t.microseconds << ',' << perPair
			  << ',' << leastPerPair << ',' << ratio << ',' << t.nodeVisits << ',' << t.blockPairs << ',' << t.ballTests << '\n';
	}

private:
	std::ofstream m_csv;
};

bool parse(int argc, char** argv, Settings& s)
{
	for (int i = 1; i < argc; ++i)
	{
		const std::string word = argv[i];
		if (word.rfind("--", 0) != 0)
		{
			s.spheres.push_back(std::atoi(argv[i]));
			if (s.spheres.back() <= 0) return false;
			continue;
		}
		if (i + 1 == argc) return false;
		const char* value = argv[++i];
		if (word == "--csv") s.csv = value;
		else if (word == "--poses") s.poses = std::atoi(value);
		else if (word == "--visits") s.visits = std::atoi(value);
		else if (word == "--cache") s.cache = value;
		else if (word == "--mesh") s.mesh = value;
		else if (word == "--only") s.only = value;
		else if (word == "--overlap") s.overlaps.push_back(std::atof(value));
		else return false;
	}
	if (s.spheres.empty()) s.spheres = {1000, 10000, 100000};
	if (s.overlaps.empty()) s.overlaps = {0.001, 0.01, 0.1, 0.5};
	return s.poses > 0 && s.visits > 0;
}
}  // namespace

int main(int argc, char** argv)
{
	Settings settings;
	if (!parse(argc, argv, settings))
	{
		std::fprintf(stderr,
			"usage: bench_query [--csv FILE] [--poses N=20] [--visits N=8] [--cache FOLDER=/tmp] [--mesh FILE]\n"
			"                   [--only naive|paper|law|law+K|law+K+patches] [--overlap FRACTION]... [SPHERES]...\n");
		return 2;
	}
	const Result<InstructionSet> set = chosenInstructionSet();
	if (!set)
	{
		std::fprintf(stderr, "bench_query: %s\n", set.error().message.c_str());
		return 1;
	}
	std::printf("instruction set: %s\n", toString(set.value()));
	Table table(settings.csv);
	for (const int spheres : settings.spheres)
	{
		const Result<InnerSphereTree> tree = body(settings, spheres);
		if (!tree)
		{
			std::fprintf(stderr, "bench_query: %s\n", tree.error().message.c_str());
			return 1;
		}
		for (const double overlap : settings.overlaps)
		{
			const std::vector<Pose> poses = bench::posesAtOverlap(tree.value(), tree.value(), overlap, settings.poses);
			if (poses.empty()) continue;
			const auto wanted = [&](const char* name) { return settings.only.empty() || settings.only == name; };
			Timing naive;
			if (wanted("naive"))
			{
				naive = measureNaive(tree.value(), tree.value(), poses, settings.visits);
				table.row(spheres, overlap, "naive", naive, naive);
			}
			for (const Mode& mode : modes())
				if (wanted(mode.name))
					table.row(spheres, overlap, mode.name, measure(tree.value(), tree.value(), poses, mode, settings.visits), naive);
		}
	}
	return 0;
}
