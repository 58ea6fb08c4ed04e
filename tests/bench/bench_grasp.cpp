// SPDX-License-Identifier: Zlib
// Measures the queries of the grasps in the UnrealHaptics paper. Sixteen fingers of 5,000 spheres surround a bunny of 10,000; eleven of
// them touch it, with 30,000 pairs of packed spheres. All fingers move by half a thousandth of the bunny's size per tick (0.1 m/s for
// 0.2 m at 1 kHz).
// A tick queries all sixteen: in the paper's mode, by the law, and by the coarsest level of the law whose error is at most that of the
// paper's mode. Times are per tick, the smallest of several passes: with one thread, with two threads, and with one thread and Verlet
// lists. Usage: bench_grasp [--ticks N=60] [--passes N=5]
#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/VerletList.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"
#include "tests/bench/bodies/BenchBodies.h"
#include "tests/bench/bodies/BenchPoses.h"
#include "tests/bench/bodies/QueryThreads.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

using namespace ist;

namespace
{
constexpr int kParts = 16, kTouching = 11, kPairs = 30000;
constexpr double kStep = 5e-4;  // motion per tick, as a share of the bunny's longest side

using Hand = std::vector<Pose>;  // pose of each part, in the object's mesh frame

struct Grasp
{
	InnerSphereTree object, part;

	int64_t pairs(const Hand& hand, const QueryOptions& options, QueryWorkspace& workspace) const
	{
		int64_t sum = 0;
		for (const Pose& X : hand) sum += queryOverlap(object, part, X, workspace, options).total.pairs;
		return sum;
	}
};

QueryOptions sumsOf(Model model, int level = 0)
{
	QueryOptions options;
	options.model = model;
	options.level = level;
	options.stiffness = options.patches = false;
	return options;
}

InnerSphereTree built(const Mesh& mesh, int spheres)
{
	BuildOptions options;
	options.maxSpheres = spheres;
	InnerSphereTree tree = buildTree(mesh, options).value();
	addLevels(tree);
	return tree;
}

/// Moves the fingers that do not touch away from the object.
Hand handAtOverlap(const Grasp& grasp, double fraction)
{
	Hand hand = bench::posesAtOverlap(grasp.object, grasp.part, fraction, kParts);
	const Vec3 center = grasp.object.origin;
	for (size_t i = kTouching; i < hand.size(); ++i)
	{
		const Vec3 out = normalized(hand[i] * grasp.part.origin - center);
		hand[i].translation += 0.2 * grasp.object.box.longestSide() * out;
	}
	return hand;
}

/// Found by bisection on the overlap of each finger that touches.
Hand handWithPairs(const Grasp& grasp, QueryWorkspace& workspace)
{
	double less = 1e-4, more = 0.9;
	for (int i = 0; i < 12; ++i)
	{
		const double fraction = std::sqrt(less * more);
		(grasp.pairs(handAtOverlap(grasp, fraction), sumsOf(Model::Inner), workspace) > kPairs ? more : less) = fraction;
	}
	return handAtOverlap(grasp, std::sqrt(less * more));
}

/// Moves each finger to and fro along its own direction.
std::vector<Hand> motion(const Grasp& grasp, const Hand& hand, int ticks)
{
	std::mt19937_64 random(7);
	std::normal_distribution<double> gauss;
	std::vector<Hand> path(static_cast<size_t>(ticks), hand);
	const double step = kStep * grasp.object.box.longestSide();
	for (size_t part = 0; part < hand.size(); ++part)
	{
		const Vec3 along = normalized({gauss(random), gauss(random), gauss(random)});
		for (int tick = 0; tick < ticks; ++tick) path[size_t(tick)][part].translation += step * std::abs(tick - ticks / 2) * along;
	}
	return path;
}

Vec3 forceOfLaw(const Grasp& grasp, const Pose& X, int level, QueryWorkspace& workspace)
{
	return pressureWrench(queryOverlap(grasp.object, grasp.part, X, workspace, sumsOf(Model::Law, level)).total, {}).force;
}

/// Root mean square over the fingers that touch. The reference of each is its force by all leaves.
double forceError(const std::vector<Vec3>& forces, const std::vector<Vec3>& leaves)
{
	double sum = 0;
	for (size_t i = 0; i < forces.size(); ++i) sum += squaredNorm(forces[i] - leaves[i]) / squaredNorm(leaves[i]);
	return std::sqrt(sum / double(forces.size()));
}

/// Uses the gain with the smallest error over these fingers.
double errorOfPaper(const Grasp& grasp, const Hand& hand, const std::vector<Vec3>& leaves, QueryWorkspace& workspace)
{
	std::vector<Vec3> forces;
	double dots = 0, squares = 0;
	for (size_t i = 0; i < leaves.size(); ++i)
	{
		forces.push_back(queryOverlap(grasp.object, grasp.part, hand[i], workspace, sumsOf(Model::Inner)).total.line.force);
		const double scale = 1 / squaredNorm(leaves[i]);
		dots += scale * dot(forces[i], leaves[i]);
		squares += scale * squaredNorm(forces[i]);
	}
	for (Vec3& force : forces) force = force * (dots / squares);
	return forceError(forces, leaves);
}

double errorOfLevel(const Grasp& grasp, const Hand& hand, const std::vector<Vec3>& leaves, int level, QueryWorkspace& workspace)
{
	std::vector<Vec3> forces;
	for (size_t i = 0; i < leaves.size(); ++i) forces.push_back(forceOfLaw(grasp, hand[i], level, workspace));
	return forceError(forces, leaves);
}

template <class Work> double microseconds(Work work)
{
	const auto start = std::chrono::steady_clock::now();
	work();
	return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

struct Times
{
	double mean = 0, worst = 0;
};

/// `beginPass` is called before each pass; `tick` queries one hand.
template <class BeginPass, class Tick> Times leastTimes(const std::vector<Hand>& path, int passes, BeginPass beginPass, Tick tick)
{
	std::vector<double> least(path.size(), 1e300);
	for (int pass = 0; pass < passes; ++pass)
	{
		beginPass();
		for (size_t i = 0; i < path.size(); ++i) least[i] = std::min(least[i], microseconds([&] { tick(path[i]); }));
	}
	Times times;
	for (const double us : least)
	{
		times.mean += us / double(least.size());
		times.worst = std::max(times.worst, us);
	}
	return times;
}

void measure(const char* name, const Grasp& grasp, const std::vector<Hand>& path, const QueryOptions& options, double error, int passes)
{
	QueryWorkspace workspace;
	std::vector<QueryWorkspace> both(2);
	std::vector<VerletList> memories(kParts);
	const auto nothing = [] {};
	const Times alone = leastTimes(path, passes, nothing, [&](const Hand& hand) { grasp.pairs(hand, options, workspace); });
	const Times two = leastTimes(path, passes, nothing, [&](const Hand& hand) {
		bench::overThreads(
			both, hand.size(), [&](size_t i, QueryWorkspace& own) { queryOverlap(grasp.object, grasp.part, hand[i], own, options); });
	});
	const Times remembered = leastTimes(
		path, passes,
		[&] {
			for (VerletList& memory : memories) memory.forget();
		},
		[&](const Hand& hand) {
			for (size_t i = 0; i < hand.size(); ++i) queryOverlap(grasp.object, grasp.part, hand[i], workspace, options, &memories[i]);
		});
	std::printf("%-22s %8lld %7.1f %% %8.0f %8.0f %8.0f %8.0f %8.0f %8.0f\n", name,
		static_cast<long long>(grasp.pairs(path[path.size() / 2], options, workspace)), 100 * error, alone.mean, alone.worst, two.mean,
		two.worst, remembered.mean, remembered.worst);
	std::fflush(stdout);
}

/// The coarsest level whose error is at most `error`.
int levelWithin(const Grasp& grasp, const Hand& hand, const std::vector<Vec3>& leaves, double error, QueryWorkspace& workspace)
{
	int level = levelCount(grasp.object, grasp.part);
	while (level > 0 && errorOfLevel(grasp, hand, leaves, level, workspace) > error) --level;
	return level;
}

bool parse(int argc, char** argv, int& ticks, int& passes)
{
	for (int i = 1; i + 1 < argc; i += 2)
	{
		const std::string word = argv[i];
		if (word != "--ticks" && word != "--passes") return false;
		(word == "--ticks" ? ticks : passes) = std::atoi(argv[i + 1]);
	}
	return argc % 2 == 1 && ticks > 1 && passes > 0;
}
}  // namespace

int main(int argc, char** argv)
{
	int ticks = 60, passes = 5;
	if (!parse(argc, argv, ticks, passes))
	{
		std::fprintf(stderr, "usage: bench_grasp [--ticks N=60] [--passes N=5]\n");
		return 2;
	}
	const Mesh bunny = bench::bunnyMesh();
	if (bunny.triangles.empty())
	{
		std::fprintf(stderr, "bench_grasp: no bunny (apt-get install glmark2-data)\n");
		return 1;
	}
	const Grasp grasp{built(bench::placed(bunny), 10000), built(makeCapsuleMesh(0.06, 0.12), 5000)};
	QueryWorkspace workspace;
	const Hand hand = handWithPairs(grasp, workspace);
	std::vector<Vec3> leaves;
	for (int i = 0; i < kTouching; ++i) leaves.push_back(forceOfLaw(grasp, hand[size_t(i)], 0, workspace));
	const double paper = errorOfPaper(grasp, hand, leaves, workspace);
	const int level = levelWithin(grasp, hand, leaves, paper, workspace);
	const std::vector<Hand> path = motion(grasp, hand, ticks);
	std::printf("microseconds a tick, mean and worst tick; error of the forces against the law's by all leaves, rms\n");
	std::printf("%-22s %8s %9s %17s %17s %17s\n", "", "pairs", "error", "one thread", "two threads", "remembered");
	measure("paper's mode", grasp, path, sumsOf(Model::Inner), paper, passes);
	measure("law, leaves", grasp, path, sumsOf(Model::Law), 0, passes);
	for (int l = level; l > 0; l -= 2)
		measure(("law, level " + std::to_string(l)).c_str(), grasp, path, sumsOf(Model::Law, l),
			errorOfLevel(grasp, hand, leaves, l, workspace), passes);
	return 0;
}
