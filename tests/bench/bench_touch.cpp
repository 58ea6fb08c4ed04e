// SPDX-License-Identifier: Zlib
// Measures contact shallower than the gaps. Bodies that only touch already press, because leaves reach beyond the surface. Prints that
// force, the effect and the cost of requireInnerOverlap, and the force of flat contact relative to the continuum. Usage: bench_touch
// [--spheres N=10000] [--poses N=20]
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "demos/scenes/Truth/OverlapQuadrature.h"
#include "demos/scenes/Truth/PoseSampler.h"
#include "tests/bench/bodies/BenchBodies.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

using namespace ist;
using namespace scenes;

namespace
{
constexpr double kSpacing = 0.0025;  // spacing of points on edges; the longest side is 1
constexpr double kTouching = 1e-6;
constexpr double kShallow = 1e-3;  // overlap with which the force of a touch is compared, as a share of the smaller volume
constexpr int kRepeats = 15;

struct Body
{
	std::string name;
	MeshDistance surface;
	std::vector<Vec3> points;  // vertices, and points along long edges
	InnerSphereTree tree;
};

/// B approaches from afar along a random line until it touches. Each step is at most the free distance.
Pose touchingPose(const Body& A, const Body& B, uint64_t seed)
{
	const Mat3 rotation = rotationMatrix(randomRotation(2 * seed));
	const Vec3 direction = rotationMatrix(randomRotation(2 * seed + 1)) * Vec3{0, 0, 1};
	Pose X{rotation, A.tree.origin + 2 * direction - rotation * B.tree.origin};
	for (double way = 1; way > kTouching; X.translation = X.translation - way * direction)
		way = bench::separation({A.surface, A.points}, {B.surface, B.points}, X);
	return X;
}

struct Answer
{
	double volume = 0, force = 0, seconds = 0;
};

Answer ask(const Body& A, const Body& B, const Pose& X, bool gate, QueryWorkspace& workspace)
{
	QueryOptions options;
	options.requireInnerOverlap = gate;
	Answer answer;
	std::vector<double> seconds;
	for (int i = 0; i < kRepeats; ++i)
	{
		const auto begin = std::chrono::steady_clock::now();
		const OverlapIntegrals total = queryOverlap(A.tree, B.tree, X, workspace, options).total;
		seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
		answer = {total.volume, norm(pressureWrench(total, {}).force), 0};
	}
	std::nth_element(seconds.begin(), seconds.begin() + kRepeats / 2, seconds.end());
	answer.seconds = seconds[kRepeats / 2];
	return answer;
}

/// The pose at which the leaves share `volume`, pushed on from a touch.
Pose pushedTo(const Body& A, const Body& B, const Pose& touch, double volume, QueryWorkspace& workspace)
{
	const Vec3 towardsA = normalized(A.tree.origin - touch * B.tree.origin);
	double least = 0, most = 0.3;
	const auto at = [&](double s) { return Pose{touch.rotation, touch.translation + s * towardsA}; };
	for (int i = 0; i < 40; ++i)
	{
		const double middle = 0.5 * (least + most);
		(queryOverlap(A.tree, B.tree, at(middle), workspace).total.volume < volume ? least : most) = middle;
	}
	return at(most);
}

void printPair(const Body& A, const Body& B, int poses)
{
	QueryWorkspace workspace;
	const double shallow = kShallow * std::min(A.tree.volume, B.tree.volume);
	double volume = 0, most = 0, force = 0, mostWithInnerOverlap = 0, kept[2] = {}, cost[2] = {};
	int reached[2] = {};  // counts poses, because a thin body may never overlap so much
	for (int i = 0; i < poses; ++i)
	{
		const Pose X = touchingPose(A, B, uint64_t(i));
		const Answer ghost = ask(A, B, X, false, workspace), gated = ask(A, B, X, true, workspace);
		volume += ghost.volume / shallow / poses;
		force += ghost.force / shallow / poses;
		most = std::max(most, ghost.volume / shallow);
		mostWithInnerOverlap = std::max({mostWithInnerOverlap, gated.volume / shallow, gated.force / shallow});
		for (const int k : {0, 1})
		{
			const Pose deep = pushedTo(A, B, X, (k == 0 ? 1 : 10) * shallow, workspace);
			const Answer open = ask(A, B, deep, false, workspace), shut = ask(A, B, deep, true, workspace);
			if (open.volume < 0.5 * (k == 0 ? 1 : 10) * shallow) continue;
			++reached[k];
			kept[k] += shut.volume / open.volume;
			cost[k] += shut.seconds / open.seconds;
		}
	}
	std::printf("%-13s %8.2f %8.2f %8.2f %8.2g | %8.1f %8.1f | %5.2f %5.2f\n", (A.name + "-" + B.name).c_str(), 100 * volume, 100 * most,
		100 * force, 100 * mostWithInnerOverlap, 100 * kept[0] / reached[0], 100 * kept[1] / reached[1], cost[0] / reached[0],
		cost[1] / reached[1]);
	std::fflush(stdout);
}
/// A box lies face down on a larger one, at random shifts and yaws. Prints the force relative to that of the continuum.
void printFlat(int spheres, int poses)
{
	Mesh large = makeBoxMesh({0.5, 0.35, 0.25}), small = large;
	for (Vec3& p : small.vertices) p = p * 0.4;
	BuildOptions options;
	options.surface = false;  // contact of leaves
	options.maxSpheres = spheres;
	const Result<InnerSphereTree> A = buildTree(large, options), B = buildTree(small, options);
	if (!A || !B) return;
	const double gaps = A.value().meanGap + B.value().meanGap;
	const OverlapQuadrature quadrature(large, small);
	QueryWorkspace workspace;
	std::printf("\nflat on flat, gap sum %.5f; force over the continuum's\n%10s %10s %8s %8s %10s\n", gaps, "depth", "gap sums", "mean",
		"std %", "gated");
	for (const double depth :
		{0.21 * gaps, 0.25 * gaps, 0.42 * gaps, 0.5 * gaps, 0.83 * gaps, gaps, 1.5 * gaps, 2 * gaps, 4 * gaps, 8 * gaps})
	{
		double sum = 0, squares = 0, gated = 0;
		std::mt19937_64 random(3);
		std::uniform_real_distribution<double> shift(-0.1, 0.1), yaw(0, 6.283185307179586);
		for (int i = 0; i < poses; ++i)
		{
			const Vec3 at{shift(random), shift(random), 0.25 + 0.4 * 0.25 - depth};
			const Pose X{rotationMatrix(quaternionFromRotationVector({0, 0, yaw(random)})), at};
			const double truth = quadrature.integrate(X, {}, 200, 100000).wrench().force.z;
			const auto ratio = [&](bool gate) {
				QueryOptions query;
				query.requireInnerOverlap = gate;
				return pressureWrench(queryOverlap(A.value(), B.value(), X, workspace, query).total, {}).force.z / truth;
			};
			const double f = ratio(false);
			sum += f / poses;
			squares += f * f / poses;
			gated += ratio(true) / poses;
		}
		std::printf("%10.5f %10.2f %8.3f %8.2f %10.3f\n", depth, depth / gaps, sum,
			100 * std::sqrt(std::max(0.0, squares - sum * sum)) / sum, gated);
		std::fflush(stdout);
	}
}
}  // namespace

int main(int argc, char** argv)
{
	int spheres = 10000, poses = 20;
	for (int i = 1; i + 1 < argc; i += 2) (std::string(argv[i]) == "--spheres" ? spheres : poses) = std::atoi(argv[i + 1]);
	std::vector<Body> bodies;
	for (const char* name : {"bunny", "box", "torus", "knot"})
	{
		const Mesh mesh = bench::placed(bench::meshNamed(name));
		BuildOptions options;
		options.surface = false;  // contact of leaves
		options.maxSpheres = spheres;
		Result<InnerSphereTree> tree = buildTree(mesh, options);
		if (tree) bodies.push_back({name, MeshDistance(mesh), bench::pointsOf(mesh, kSpacing), std::move(tree).value()});
		else std::printf("%s: %s\n", name, tree.error().message.c_str());
	}
	std::printf("%d spheres, %d poses of exact touch; %% of the volume (force: of the force k V) at %g %% overlap\n", spheres, poses,
		100 * kShallow);
	std::printf(
		"%-13s %8s %8s %8s %8s | %8s %8s | %5s %5s\n", "", "volume", "most", "force", "gated", "kept .1%", "kept 1%", "time", "time");
	for (size_t a = 0; a < bodies.size(); ++a)
		for (size_t b = a; b < bodies.size(); ++b) printPair(bodies[a], bodies[b], poses);
	printFlat(spheres, poses);
	return 0;
}
