// SPDX-License-Identifier: Zlib
// Compares trees with bodies in closed form: time, and error against quadrature on the triangles of both. Overlaps are 0.1, 1 and 10 %
// of the smaller body, in seeded random poses. `--flat` presses a cube of 0.1 m onto a half-space, a box and a floor of 50 m instead.
// Usage: bench_fields [--spheres N=10000] [--poses N=10] [--only PART-OF-NAME] [--flat 1]
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "demos/scenes/Bodies/FieldBodies.h"
#include "demos/scenes/Truth/OverlapQuadrature.h"
#include "demos/scenes/Truth/PoseSampler.h"
#include "tests/bench/bodies/BenchBodies.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <random>
#include <string>
#include <vector>

using namespace ist;
using bench::bunnyMesh, bench::placed;
using namespace scenes;

namespace
{
struct Row
{
	int poses = 0, oneSigma = 0, twoSigma = 0;
	double volume = 0, bias = 0, force = 0, torque = 0, leaves = 0, seconds = 0;
	std::vector<double> angles;
};

double secondsOf(
	const InnerSphereTree& tree, const AnalyticField& field, const Pose& X, QueryWorkspace& workspace, const QueryOptions& options = {})
{
	std::vector<double> times;
	for (int i = 0; i < 5; ++i)
	{
		const auto begin = std::chrono::steady_clock::now();
		queryField(tree, field, X, workspace, options);
		times.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
	}
	std::nth_element(times.begin(), times.begin() + 2, times.end());
	return times[2];
}

Row measure(const Mesh& mesh, const InnerSphereTree& tree, const FieldBody& body, double overlap, int count)
{
	const OverlapQuadrature quadrature(mesh, body.mesh);
	QueryWorkspace workspace;
	Row row;
	for (const Pose& X : posesAtOverlap(quadrature, overlap, count, 11))
	{
		const QuadratureTruth truth = quadrature.integrate(X, tree.origin, overlap < 0.005 ? 160 : 120, 60000);
		const OverlapResult answer = queryField(tree, *body.field, X, workspace);
		const OverlapIntegrals& found = answer.total;
		const Wrench expected = truth.wrench(), actual = pressureWrench(found, {});
		const double relative = found.volume / truth.volume - 1, size = norm(expected.force), error = norm(actual.force - expected.force);
		const double arm = size * std::min(bounds(mesh).longestSide(), bounds(body.mesh).longestSide());
		const OverlapError sigma = overlapError(answer, tree, 1);
		++row.poses;
		row.volume += relative * relative;
		row.bias += relative;
		row.force += error * error / (size * size);
		row.torque += squaredNorm(actual.torque - expected.torque) / (arm * arm);
		row.leaves += double(found.pairs);
		row.oneSigma += error <= sigma.force;
		row.twoSigma += error <= 2 * sigma.force;
		row.angles.push_back(
			180 / std::numbers::pi * std::atan2(norm(cross(actual.force, expected.force)), dot(actual.force, expected.force)));
		row.seconds += secondsOf(tree, *body.field, X, workspace);
	}
	std::sort(row.angles.begin(), row.angles.end());
	return row;
}

void print(const std::string& name, double overlap, const Row& row)
{
	const double n = std::max(1, row.poses);
	const auto rms = [n](double squares) { return 100 * std::sqrt(squares / n); };
	std::printf("%-20s %6.1f%% %5d %7.0f | %+6.2f %6.2f | %6.2f %6.2f %5.0f %5.0f | %6.2f | %8.1f us, %4.0f ns a leaf\n", name.c_str(),
		100 * overlap, row.poses, row.leaves / n, 100 * row.bias / n, rms(row.volume), rms(row.force),
		row.angles.empty() ? 0 : row.angles[row.angles.size() / 2], 100 * row.oneSigma / n, 100 * row.twoSigma / n, rms(row.torque),
		1e6 * row.seconds / n, 1e9 * row.seconds / std::max(1.0, row.leaves));
	std::fflush(stdout);
}

/// A cube of 0.1 m flat on closed forms at random places: the largest error of force over k V, of surfaces and of leaves, and the median
/// times of both.
void pressFlat(int spheres, int poses)
{
	constexpr double kHalf = 0.05;
	BuildOptions options;
	options.maxSpheres = spheres;
	const InnerSphereTree cube = buildTree(makeBoxMesh({kHalf, kHalf, kHalf}), options).value();
	const struct
	{
		const char* name;
		Vec3 half;
	} forms[] = {{"half-space", {}}, {"box", {0.2, 0.15, 0.03}}, {"floor", {25, 25, 0.5}}};
	std::printf("%-10s %8s | %10s %10s | %8s %8s\n", "cube on", "depth", "surfaces", "leaves", "us", "us");
	QueryWorkspace workspace;
	QueryOptions ofLeaves;
	ofLeaves.model = Model::Leaf;
	std::mt19937 random(1);
	std::uniform_real_distribution<double> u(-1, 1);
	for (const auto& form : forms)
		for (const double depth : {1e-5, 1e-4, 1e-3, 1e-2})
		{
			const BoxField box(form.half);
			const HalfSpaceField plane({0, 0, 1}, 0);
			const bool isBox = form.half.z > 0;
			const AnalyticField& field = isBox ? static_cast<const AnalyticField&>(box) : plane;
			double error[2] = {};
			std::vector<double> times[2];
			for (int i = 0; i < poses; ++i)
			{
				// The cube stays clear of the edges, where the walls of a box press, too.
				const double angle = std::numbers::pi * u(random), x = std::max(form.half.x - 0.09, 0.0),
							 y = std::max(form.half.y - 0.09, 0.0);
				const Mat3 turn = rotationMatrix(quaternionFromRotationVector({0, 0, angle}));
				const Pose X{turn, Vec3{0, 0, depth - kHalf - form.half.z} - turn * Vec3{x * u(random), y * u(random), 0}};
				for (int leaves = 0; leaves < 2; ++leaves)
				{
					const QueryOptions asked = leaves ? ofLeaves : QueryOptions();
					const double expected = 4 * kHalf * kHalf * depth;
					const double force = queryField(cube, field, X, workspace, asked).total.normalB.force.z;
					error[leaves] = std::max(error[leaves], std::fabs(force / expected - 1));
					times[leaves].push_back(1e6 * secondsOf(cube, field, X, workspace, asked));
				}
			}
			for (auto& t : times) std::nth_element(t.begin(), t.begin() + long(t.size() / 2), t.end());
			const auto median = [&](int i) { return times[i][times[i].size() / 2]; };
			std::printf(
				"%-10s %6.0e m | %9.5f%% %9.3f%% | %8.1f %8.1f\n", form.name, depth, 100 * error[0], 100 * error[1], median(0), median(1));
		}
}
}  // namespace

int main(int argc, char** argv)
{
	int spheres = 10000, poses = 10;
	bool flat = false;
	std::string only;
	for (int i = 1; i + 1 < argc; i += 2)
	{
		const std::string key = argv[i];
		if (key == "--spheres") spheres = std::atoi(argv[i + 1]);
		else if (key == "--poses") poses = std::atoi(argv[i + 1]);
		else if (key == "--only") only = argv[i + 1];
		else if (key == "--flat") flat = true;
	}
	if (flat) return pressFlat(spheres, poses), 0;
	std::printf("%-20s %7s %5s %7s | %6s %6s | %6s %6s %5s %5s | %6s |\n", "rms in %", "overlap", "poses", "leaves", "V bias", "V rms",
		"F rms", "deg", "1 sig", "2 sig", "T rms");
	const struct
	{
		const char* name;
		Mesh mesh;
	} bodies[] = {{"bunny", bunnyMesh()}, {"box", makeBoxMesh({0.5, 0.35, 0.25})}, {"torus", makeTorusMesh(0.5, 0.2, 144, 72)}};
	for (const auto& source : bodies)
	{
		if (source.mesh.triangles.empty())
		{
			std::printf("%s: skipped; apt-get install glmark2-data\n", source.name);
			continue;
		}
		const Mesh mesh = placed(source.mesh);
		BuildOptions options;
		options.maxSpheres = spheres;
		const Result<InnerSphereTree> tree = buildTree(mesh, options);
		if (!tree) return std::printf("%s: %s\n", source.name, tree.error().message.c_str()), 1;
		for (const FieldBody& body : makeFieldBodies(1))
		{
			const std::string name = std::string(source.name) + "-" + body.name;
			if (name.find(only) == std::string::npos) continue;
			for (const double overlap : {0.001, 0.01, 0.1}) print(name, overlap, measure(mesh, tree.value(), body, overlap, poses));
		}
	}
	return 0;
}
