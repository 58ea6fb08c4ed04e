// SPDX-License-Identifier: Zlib
// Measures contact of surfaces (Core/Surface, surfaceOverlap) beside contact of leaves (queryOverlap): errors against quadrature on the
// triangles, and time, in the same seeded poses.
// Usage: bench_surface [--spheres N=1000] [--cells N=1500] [--elements N=1500] [--poses N=6] [--pairs compact|thin] [--truth FOLDER]
// Errors are root mean squares over the poses, in %; those of the force are relative to it, or to a quarter of k V where opposing forces
// leave less. --spheres 0 leaves out the leaves. --truth keeps the quadrature's results from run to run.
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Query/QueryWorkspaceState.h"
#include "BulletISTCollision/Core/Query/SurfaceOverlap.h"
#include "tests/bench/bodies/BenchBodies.h"
#include "tests/bench/bodies/TruePoses.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

using namespace ist;

namespace
{
constexpr double kOverlaps[] = {1e-4, 1e-3, 0.01, 0.05, 0.2, 0.5};
constexpr double kCancelled = 0.25;
constexpr int kVisits = 9;

struct Options
{
	int spheres = 1000, cells = 1500, elements = 1500, poses = 6;
	std::string pairs = "compact", truth;
};

struct Body
{
	BodySurface surface;
	InnerSphereTree tree;
	Vec3 center;
};

Body makeBody(const std::string& name, const Options& options)
{
	const Mesh mesh = bench::placed(bench::meshNamed(name));
	Body body;
	body.center = massProperties(mesh).centerOfMass;
	BodySurfaceOptions surface;
	surface.cells = options.cells;
	surface.elements = options.elements;
	body.surface = buildBodySurface(MeshDistance(translated(mesh, -body.center), 2), surface).value();
	if (options.spheres > 0)
	{
		BuildOptions tree;
		tree.maxSpheres = options.spheres;
		body.tree = buildTree(mesh, tree).value();
	}
	return body;
}

/// Median time of a call [us].
template <class Call> double timeOf(const Call& call)
{
	std::vector<double> times;
	for (int i = 0; i < kVisits; ++i)
	{
		const auto start = std::chrono::steady_clock::now();
		call();
		times.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
	}
	std::nth_element(times.begin(), times.begin() + kVisits / 2, times.end());
	return times[kVisits / 2];
}

struct Sums
{
	int poses = 0;
	double volume = 0, force = 0, oldVolume = 0, oldForce = 0, time = 0, oldTime = 0, faces = 0, pairs = 0, nodes = 0;
};

void measure(const Body& A, const Body& B, const bench::TruePose& pose, bool hasTrees, Sums& sums)
{
	static QueryWorkspace leaves;
	static SurfaceWorkspace surfaces(200000, 8, leaves.implementation().kernel);
	Pose X = pose.X_AB;
	X.translation = X * B.center - A.center;
	const Vec3 force = pose.truth.wrench().force;
	const double volume = pose.truth.volume, size = std::max(norm(force), kCancelled * volume);
	const auto square = [](double x) { return x * x; };
	const auto forceOf = [](const OverlapIntegrals& total) { return 0.5 * (total.normalB.force - total.normalA.force); };

	SurfaceOverlap found;
	sums.time += timeOf([&] { found = surfaceOverlap(A.surface, B.surface, X, surfaces); });
	++sums.poses;
	sums.volume += square(found.total.volume / volume - 1);
	sums.force += square(norm(forceOf(found.total) - force) / size);
	sums.faces += double(found.countA + found.countB);
	sums.nodes += double(found.counts.nodes);
	if (!hasTrees) return;
	QueryOptions options;
	options.model = Model::Leaf;
	OverlapResult old;
	sums.oldTime += timeOf([&] { old = queryOverlap(A.tree, B.tree, pose.X_AB, leaves, options); });
	sums.oldVolume += square(old.total.volume / volume - 1);
	sums.oldForce += square(norm(forceOf(old.total) - force) / size);
	sums.pairs += double(old.total.pairs);
}
}  // namespace

int main(int argc, char** argv)
{
	Options options;
	for (int i = 1; i + 1 < argc; i += 2)
	{
		const std::string name = argv[i], value = argv[i + 1];
		if (name == "--spheres") options.spheres = std::atoi(value.c_str());
		else if (name == "--cells") options.cells = std::atoi(value.c_str());
		else if (name == "--elements") options.elements = std::atoi(value.c_str());
		else if (name == "--poses") options.poses = std::atoi(value.c_str());
		else if (name == "--pairs") options.pairs = value;
		else if (name == "--truth") options.truth = value;
		else return std::fprintf(stderr, "unknown option %s\n", name.c_str()), 2;
	}
	using Pairs = std::vector<std::pair<std::string, std::string>>;
	const Pairs compact = {{"bunny", "bunny"}, {"box", "bunny"}, {"torus", "torus"}, {"jack", "torus"}, {"knot", "bunny"}};
	const Pairs thin = {{"plate", "bunny"}, {"rod", "jack"}, {"wire", "jack"}, {"crown", "bunny"}, {"sword", "torus"}, {"plate", "knot"}};
	std::map<std::string, Body> bodies;
	std::printf("%-12s %8s | %7s %7s %8s %8s %8s | %7s %7s %8s %8s\n", "pair", "overlap", "V [%]", "F [%]", "time[us]", "faces", "nodes",
		"V, old", "F, old", "time[us]", "pairs");
	for (const auto& [a, b] : options.pairs == "thin" ? thin : compact)
	{
		for (const std::string& name : {a, b})
			if (!bodies.count(name)) bodies.emplace(name, makeBody(name, options));
		bench::TruthSettings settings;
		settings.overlaps.assign(std::begin(kOverlaps), std::end(kOverlaps));
		settings.poses = options.poses;
		settings.lines = 300;
		settings.points = 60000;
		std::map<double, Sums> sums;
		for (const bench::TruePose& pose : bench::truePoses(a, b, settings, options.truth))
			measure(bodies[a], bodies[b], pose, options.spheres > 0, sums[pose.overlap]);
		for (const auto& [overlap, s] : sums)
		{
			const auto percent = [poses = s.poses](double squares) { return 100 * std::sqrt(squares / poses); };
			std::printf("%-12s %6g %% | %7.2f %7.2f %8.1f %8.0f %8.0f | %7.2f %7.2f %8.1f %8.0f\n", (a + " " + b).c_str(), 100 * overlap,
				percent(s.volume), percent(s.force), s.time / s.poses, s.faces / s.poses, s.nodes / s.poses, percent(s.oldVolume),
				percent(s.oldForce), s.oldTime / s.poses, s.pairs / s.poses);
			std::fflush(stdout);
		}
	}
	return 0;
}
