// SPDX-License-Identifier: Zlib
// What a second thread saves: one query with a QueryHelper, side by side with the query alone, and a batch over 1 and 2 threads.
// Each pose's least of several visits, in shuffled order. Usage: bench_threads [--visits N=20] BODY.ist...
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Query/BatchQuery.h"
#include "BulletISTCollision/Core/Query/QueryHelper.h"
#include "tests/bench/bodies/BenchPoses.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <random>
#include <string>

using namespace ist;

namespace
{
template <class Work> double microseconds(Work work)
{
	const auto start = std::chrono::steady_clock::now();
	work();
	return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

double mean(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size()); }
double median(std::vector<double> values)
{
	std::nth_element(values.begin(), values.begin() + ptrdiff_t(values.size() / 2), values.end());
	return values[values.size() / 2];
}

void measure(const InnerSphereTree& body, double overlap, const char* name, const QueryOptions& options, int visits)
{
	const std::vector<Pose> poses = bench::posesAtOverlap(body, body, overlap, 12);
	if (poses.empty()) return;
	QueryWorkspace alone, shared;
	QueryHelper helper({}, 2000);
	shared.setHelper(&helper);
	std::vector<double> one(poses.size(), 1e300), two(poses.size(), 1e300), ratios;
	double pairs = 0, other = 0;
	std::vector<size_t> order(poses.size());
	std::iota(order.begin(), order.end(), size_t(0));
	std::mt19937 random(1);
	for (int visit = 0; visit < visits; ++visit)
	{
		std::shuffle(order.begin(), order.end(), random);
		for (const size_t i : order)
		{
			OverlapResult a, b;
			const double first = microseconds([&] { a = queryOverlap(body, body, poses[i], alone, options); });
			const double second = microseconds([&] { b = queryOverlap(body, body, poses[i], shared, options); });
			one[i] = std::min(one[i], first);
			two[i] = std::min(two[i], second);
			ratios.push_back(first / second);
			if (visit > 0) continue;
			pairs += double(a.total.pairs) / double(poses.size());
			other += a.total.pairs != b.total.pairs;
		}
	}
	std::vector<OverlapRequest> requests;
	for (int repeat = 0; repeat < 4; ++repeat)
		for (const Pose& X : poses) requests.push_back({&body, &body, X, options});
	std::vector<OverlapResult> answers(requests.size());
	double batches[2] = {1e300, 1e300};
	for (int threads = 1; threads <= 2; ++threads)
	{
		BatchQuery batch(threads);
		for (int visit = 0; visit < visits; ++visit)
			batches[threads - 1] = std::min(
				batches[threads - 1], microseconds([&] { batch.run(requests.data(), answers.data(), requests.size()); }));
	}
	std::printf("%8u %8g %-14s %9.0f %10.2f %10.2f %8.2f %8.2f %12.0f %10.2f\n", body.law.ballCount(), overlap, name, pairs, mean(one),
		mean(two), mean(one) / mean(two), median(ratios), other, batches[0] / batches[1]);
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
	std::printf("%8s %8s %-14s %9s %10s %10s %8s %8s %12s %10s\n", "leaves", "overlap", "mode", "pairs", "alone us", "shared us", "ratio",
		"median", "other pairs", "batch x");
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
