// SPDX-License-Identifier: Zlib
// Measures what a second thread saves: a batch of queries over 1 and 2 threads, each with its own workspace. The smallest time of
// several visits counts. Usage: bench_threads [--visits N=20] BODY.ist...
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "tests/bench/bodies/BenchPoses.h"
#include "tests/bench/bodies/QueryThreads.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <string>
#include <vector>

using namespace ist;

namespace
{
template <class Work> double microseconds(Work work)
{
	const auto start = std::chrono::steady_clock::now();
	work();
	return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

void measure(const InnerSphereTree& body, double overlap, const char* name, const QueryOptions& options, int visits)
{
	const std::vector<Pose> poses = bench::posesAtOverlap(body, body, overlap, 12);
	if (poses.empty()) return;
	const size_t queries = 4 * poses.size();
	std::vector<int64_t> pairs(queries);
	double batches[2] = {1e300, 1e300};
	for (int threads = 1; threads <= 2; ++threads)
	{
		std::vector<QueryWorkspace> workspaces(static_cast<size_t>(threads));
		const auto ask = [&](size_t i, QueryWorkspace& workspace) {
			pairs[i] = queryOverlap(body, body, poses[i % poses.size()], workspace, options).total.pairs;
		};
		for (int visit = 0; visit < visits; ++visit)
			batches[threads - 1] = std::min(batches[threads - 1], microseconds([&] { bench::overThreads(workspaces, queries, ask); }));
	}
	const double mean = double(std::accumulate(pairs.begin(), pairs.end(), int64_t(0))) / double(queries);
	std::printf("%8u %8g %-14s %9.0f %12.2f %12.2f %8.2f\n", body.law.ballCount(), overlap, name, mean, batches[0] / double(queries),
		batches[1] / double(queries), batches[0] / batches[1]);
	std::fflush(stdout);
}
}  // namespace

int main(int argc, char** argv)
{
	int visits = 20;
	std::vector<std::string> files;
	for (int i = 1; i < argc; ++i)
	{
		const std::string word = argv[i];
		if (word == "--visits" && i + 1 < argc) visits = std::max(1, std::atoi(argv[++i]));
		else if (word.rfind("--", 0) == 0) files.clear(), i = argc;
		else files.push_back(word);
	}
	if (files.empty())
	{
		std::fprintf(stderr, "usage: bench_threads [--visits N=20] BODY.ist...\n");
		return 2;
	}
	QueryOptions paper, law, full;
	paper.model = Model::Inner;
	paper.stiffness = paper.patches = law.stiffness = law.patches = false;
	const struct
	{
		const char* name;
		QueryOptions options;
	} modes[] = {{"paper", paper}, {"law", law}, {"law+K+patches", full}};
	std::printf("%8s %8s %-14s %9s %12s %12s %8s\n", "leaves", "overlap", "mode", "pairs", "one: us each", "two: us each", "ratio");
	for (const std::string& file : files)
	{
		const Result<InnerSphereTree> body = loadAsset(file);
		if (!body)
		{
			std::fprintf(stderr, "bench_threads: %s\n", body.error().message.c_str());
			return 1;
		}
		for (const double overlap : {0.0001, 0.001, 0.01, 0.1, 0.5})
			for (const auto& mode : modes) measure(body.value(), overlap, mode.name, mode.options, visits);
	}
	return 0;
}
