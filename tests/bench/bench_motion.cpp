// SPDX-License-Identifier: Zlib
// Measures what VerletList saves where a body moves at 1 kHz with 0.1 m/s per 0.2 m of its size, bunny against bunny. Prints the time
// of a query with it and without; the time of each step is the smallest of several passes over the same path. Usage: bench_motion
// [--steps N=200] [--passes N=8] [--speed S=0.0005 (sizes per query)] BODY.ist...
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Query/VerletList.h"
#include "tests/bench/bodies/BenchPoses.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

using namespace ist;

namespace
{
struct Settings
{
	int steps = 200, passes = 8;
	double speed = 5e-4;
	std::vector<std::string> files;
};

/// A straight slide with a rotation. The rotation causes half of the motion of the outermost points.
std::vector<Pose> path(const InnerSphereTree& B, const Pose& start, double step, int steps, std::mt19937& random)
{
	std::normal_distribution<double> gauss;
	const Vec3 along = normalized({gauss(random), gauss(random), gauss(random)}),
			   axis = normalized({gauss(random), gauss(random), gauss(random)});
	const double reach = 0.5 * norm(B.box.upper - B.box.lower);
	const Vec3 center = start * B.origin;
	std::vector<Pose> poses;
	for (int i = 0; i < steps; ++i)
	{
		const double s = 0.5 * step * (i - steps / 2);
		const Mat3 turn = rotationMatrix(quaternionFromRotationVector(axis * (s / reach)));
		Pose X;
		X.rotation = turn * start.rotation;
		X.translation = center + along * s - X.rotation * B.origin;
		poses.push_back(X);
	}
	return poses;
}

template <class Query> double microseconds(Query query)
{
	const auto start = std::chrono::steady_clock::now();
	query();
	return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

struct Outcome
{
	double fresh = 0, kept = 0, worst = 0, pairs = 0, searched = 0, error = 0, otherPairs = 0;
};

Outcome measure(const InnerSphereTree& body, const std::vector<Pose>& poses, const QueryOptions& options, int passes)
{
	QueryWorkspace workspace, other;
	VerletList memory(4000000);
	const size_t n = poses.size();
	std::vector<double> fresh(n, 1e300), kept(n, 1e300);
	Outcome o;
	for (int pass = 0; pass < passes; ++pass)
	{
		memory.forget();
		for (size_t i = 0; i < n; ++i)
		{
			OverlapResult a, b;
			fresh[i] = std::min(fresh[i], microseconds([&] { a = queryOverlap(body, body, poses[i], other, options); }));
			kept[i] = std::min(kept[i], microseconds([&] { b = queryOverlap(body, body, poses[i], workspace, options, &memory); }));
			if (pass > 0) continue;
			o.pairs += double(a.total.pairs) / double(n);
			o.searched += (b.nodeVisits > 0) / double(n);
			o.otherPairs += a.total.pairs != b.total.pairs;
			o.error = std::max(o.error, std::fabs(a.total.volume - b.total.volume) / std::max(a.total.volume, 1e-300));
			o.error = std::max(o.error, norm(a.total.areaVector - b.total.areaVector) / std::max(norm(a.total.areaVector), 1e-300));
		}
	}
	for (size_t i = 0; i < n; ++i)
	{
		o.fresh += fresh[i] / double(n);
		o.kept += kept[i] / double(n);
		o.worst = std::max(o.worst, kept[i] / fresh[i]);
	}
	return o;
}

bool parse(int argc, char** argv, Settings& s)
{
	for (int i = 1; i < argc; ++i)
	{
		const std::string word = argv[i];
		if (word.rfind("--", 0) != 0)
		{
			s.files.push_back(word);
			continue;
		}
		if (++i == argc) return false;
		if (word == "--steps") s.steps = std::atoi(argv[i]);
		else if (word == "--passes") s.passes = std::atoi(argv[i]);
		else if (word == "--speed") s.speed = std::atof(argv[i]);
		else return false;
	}
	return !s.files.empty() && s.steps > 0 && s.passes > 0 && s.speed >= 0;
}
}  // namespace

int main(int argc, char** argv)
{
	Settings settings;
	if (!parse(argc, argv, settings))
	{
		std::fprintf(stderr, "usage: bench_motion [--steps N=200] [--passes N=8] [--speed S=0.0005] BODY.ist...\n");
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
	std::printf("%8s %8s %-14s %9s %10s %10s %7s %11s %9s %11s %11s\n", "leaves", "overlap", "mode", "pairs", "fresh us", "kept us",
		"ratio", "worst step", "searched", "other pairs", "difference");
	for (const std::string& file : settings.files)
	{
		const Result<InnerSphereTree> body = loadAsset(file);
		if (!body)
		{
			std::fprintf(stderr, "bench_motion: %s\n", body.error().message.c_str());
			return 1;
		}
		const double step = settings.speed * body.value().box.longestSide();
		for (const double overlap : {0.001, 0.01, 0.1, 0.5})
			for (const auto& mode : modes)
			{
				Outcome sum;
				std::mt19937 random(3);
				const std::vector<Pose> starts = bench::posesAtOverlap(body.value(), body.value(), overlap, 3);
				for (const Pose& start : starts)
				{
					const Outcome o = measure(
						body.value(), path(body.value(), start, step, settings.steps, random), mode.options, settings.passes);
					const double share = 1 / double(starts.size());
					sum.fresh += share * o.fresh;
					sum.kept += share * o.kept;
					sum.pairs += share * o.pairs;
					sum.searched += share * o.searched;
					sum.otherPairs += o.otherPairs;
					sum.worst = std::max(sum.worst, o.worst);
					sum.error = std::max(sum.error, o.error);
				}
				std::printf("%8u %8g %-14s %9.0f %10.2f %10.2f %7.2f %11.2f %8.1f%% %11.0f %11.1e\n", body.value().law.ballCount(), overlap,
					mode.name, sum.pairs, sum.fresh, sum.kept, sum.fresh / sum.kept, sum.worst, 100 * sum.searched, sum.otherPairs,
					sum.error);
				std::fflush(stdout);
			}
	}
	return 0;
}
