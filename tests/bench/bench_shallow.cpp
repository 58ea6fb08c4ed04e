// SPDX-License-Identifier: Zlib
// Measures contact below the gaps of the packing, where bodies touch or fit into each other: flat contact, the distance at which contact
// begins, a pin in a bore, a floor, and bodies in one place. Usage: bench_shallow [--spheres N=1000] [--leaves]
// --leaves: asks the leaves instead of the surfaces.
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "tests/bench/bodies/BenchBodies.h"
#include "tests/unit/BoredMesh.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <random>
#include <vector>

using namespace ist;

namespace
{
constexpr double kPi = std::numbers::pi;

struct Body
{
	MeshDistance surface;
	InnerSphereTree tree;
};

Body bodyOf(const Mesh& mesh, int64_t spheres)
{
	BuildOptions options;
	options.maxSpheres = spheres;
	return {MeshDistance(mesh), buildTree(mesh, options).value()};
}

/// `axis` has unit length.
Mat3 turned(double angle, const Vec3& axis) { return rotationMatrix(quaternionFromRotationVector(angle * axis)); }

class Bench
{
public:
	Bench(int64_t spheres, bool leaves) : m_spheres(spheres) { m_options.model = leaves ? Model::Leaf : Model::Law; }

	void flat();
	void announced(const char* name, const Mesh& mesh);
	void pin();
	void floor();
	void inOnePlace();

private:
	OverlapResult ask(const Body& A, const Body& B, const Pose& X_AB) { return queryOverlap(A.tree, B.tree, X_AB, m_workspace, m_options); }
	Vec3 force(const Body& A, const Body& B, const Pose& X_AB) { return pressureWrench(ask(A, B, X_AB).total, {}).force; }
	double random() { return std::uniform_real_distribution<double>(-1, 1)(m_random); }

	int64_t m_spheres;
	QueryOptions m_options;
	QueryWorkspace m_workspace;
	std::mt19937_64 m_random{1};
};

/// A box of 0.4 x 0.4 x 0.2 m on one of 1 x 1 x 0.4 m. Exact: with the wedges at the box's edges, where its own normals turn.
void Bench::flat()
{
	const Body table = bodyOf(makeBoxMesh({0.5, 0.5, 0.2}), m_spheres), box = bodyOf(makeBoxMesh({0.2, 0.2, 0.1}), m_spheres);
	const double gaps = table.tree.meanGap + box.tree.meanGap, side = 0.4, area = side * side;
	std::printf("flat contact, gap sum %.3g mm: force over exact, its deviation, stiffness over k A\n", 1e3 * gaps);
	for (const double share : {-0.05, 0.0, 0.1, 0.25, 0.5, 1.0, 2.0})
	{
		const double depth = share * gaps, inner = side - 2 * depth;
		const double exact = 0.5 * (area * depth + (side * side * side - inner * inner * inner) / 6);
		double sum = 0, squares = 0, stiffness = 0;
		constexpr int kPoses = 12;
		for (int i = 0; i < kPoses; ++i)
		{
			const Pose X{turned(kPi * random(), {0, 0, 1}), {0.2 * random(), 0.2 * random(), 0.3 - depth}};
			const OverlapResult found = ask(table, box, X);
			const double scale = share > 0 ? exact : area * gaps, f = -pressureWrench(found.total, {}).force.z / scale;
			sum += f;
			squares += f * f;
			stiffness += pressureStiffness(found.total, {})(2, 2) / area / kPoses;
		}
		const double mean = sum / kPoses;
		std::printf("  %5.2f gap sums: %.4f +- %.4f, %.3f%s\n", share, mean, std::sqrt(std::max(0.0, squares / kPoses - mean * mean)),
			stiffness, share > 0 ? "" : " (force over that of one gap sum)");
	}
}

/// The distance of two equal bodies when contact begins, from 20 random directions and turns.
void Bench::announced(const char* name, const Mesh& mesh)
{
	const Body body = bodyOf(mesh, m_spheres);
	const std::vector<Vec3> points = bench::pointsOf(mesh, bounds(mesh).longestSide() / 2000);
	const bench::SampledSurface meshOf{body.surface, points};
	double largest = 0, mean = 0;
	constexpr int kPoses = 20;
	for (int i = 0; i < kPoses; ++i)
	{
		const Vec3 way = normalized(Vec3{random(), random(), random()});
		const Mat3 R = turned(kPi * random(), normalized(Vec3{random(), random(), random()}));
		double apart = 3 * bounds(mesh).longestSide(), meets = 0;
		// The first contact along the way, to a micrometre; steps of a two hundredth find it.
		const double step = apart / 200;
		while (apart > 0 && !(ask(body, body, {R, (apart - step) * way}).total.volume > 0)) apart -= step;
		meets = apart - step;
		while (apart - meets > 1e-7)
		{
			const double middle = 0.5 * (apart + meets);
			(ask(body, body, {R, middle * way}).total.volume > 0 ? meets : apart) = middle;
		}
		// Where edges cross, the points of both give it within a thousandth of the size.
		const double distance = bench::separation(meshOf, meshOf, {R, apart * way});
		largest = std::max(largest, distance);
		mean += distance / kPoses;
	}
	std::printf("contact of two %s begins %.4f mm apart (largest of %d; mean %.4f); 5 %% of a mean gap is %.4f mm\n", name, 1e3 * largest,
		kPoses, 1e3 * mean, 50 * body.tree.meanGap);
}

/// A pin of 20 mm in a bore: the shared volume while it is free, and the force when it is pushed beyond the clearance.
void Bench::pin()
{
	constexpr int kSegments = 384;
	constexpr double kRadius = 0.01, kLength = 0.02;
	const Body pin = bodyOf(makeCylinderMesh(kRadius, 0.02, kSegments), m_spheres);
	for (const double clearance : {1e-3, 0.25e-3, 0.05e-3, 0.01e-3})
	{
		const Body block = bodyOf(boredMesh(kRadius + clearance, {0.03, true}, 0.01, kSegments), m_spheres);
		double most = 0;
		for (int turn = 0; turn < 20; ++turn)
			most = std::max(most, ask(block, pin, {turned(2 * kPi * (turn + 0.3) / 20, {0, 0, 1}), {}}).total.volume);
		std::printf("pin, clearance %.2f mm: %.4f mm^3 when free;", 1e3 * clearance, 1e9 * most);
		for (const double beyond : {5e-6, 20e-6, 100e-6})
		{
			// First order in the depth: d = e cos(t) - c along the bore, on the surface between the two.
			const double e = clearance + beyond;
			double exact = 0;
			constexpr int kParts = 100000;
			for (int i = 0; i < kParts; ++i)
			{
				const double t = 2 * kPi * (i + 0.5) / kParts;
				exact += (kRadius + clearance / 2) * kLength * std::max(0.0, e * std::cos(t) - clearance) * std::cos(t) * 2 * kPi / kParts;
			}
			double ratio = 0, off = 0;
			for (int turn = 0; turn < 20; ++turn)
			{
				const double angle = 2 * kPi * (turn + 0.3) / 20;
				const Vec3 way{std::cos(2.1 * angle), std::sin(2.1 * angle), 0};
				const Vec3 f = force(block, pin, {turned(angle, {0, 0, 1}), e * way});
				ratio += norm(f) / exact / 20;
				off = std::max(off, std::acos(std::min(1.0, dot(f, way) / std::max(norm(f), 1e-300))) * 180 / kPi);
			}
			std::printf(" %.0f um beyond: %.3f of exact, %.1f degrees;", 1e6 * beyond, ratio, off);
		}
		std::printf("\n");
	}
}

/// A crate of 0.3 m on a floor of 50 x 0.2 x 50 m.
void Bench::floor()
{
	const Body ground = bodyOf(makeBoxMesh({25, 0.1, 25}), m_spheres), crate = bodyOf(makeBoxMesh({0.15, 0.15, 0.15}), m_spheres);
	constexpr double kDepth = 1e-3;
	double least = 1e300, most = 0;
	for (int i = 0; i < 40; ++i)
	{
		const Pose X{turned(kPi * random(), {0, 1, 0}), {24 * random(), 0.25 - kDepth, 24 * random()}};
		const double ratio = -force(ground, crate, X).y / (0.09 * kDepth);
		least = std::min(least, ratio);
		most = std::max(most, ratio);
	}
	std::printf("crate on a floor of 50 m, 1 mm deep, 40 places: force over k V %.4f to %.4f\n", least, most);
}

/// Share of the body's volume that it has in common with itself in another pose, from random points in it.
double commonShare(const MeshDistance& surface, const Box& box, const Pose& X)
{
	constexpr int kPoints = 1'000'000;
	const Pose back = inverse(X);
	std::mt19937_64 random{2};
	std::uniform_real_distribution<double> unit(0, 1);
	int inside = 0, common = 0;
	while (inside < kPoints)
	{
		Vec3 x;
		for (int k = 0; k < 3; ++k) x[k] = box.lower[k] + unit(random) * (box.upper[k] - box.lower[k]);
		if (!surface.contains(x)) continue;
		++inside;
		common += surface.contains(back * x);
	}
	return double(common) / kPoints;
}

void Bench::inOnePlace()
{
	for (const char* name : {"bunny", "torus", "knot"})
	{
		const Mesh mesh = bench::placed(bench::meshNamed(name));
		const Body body = bodyOf(mesh, m_spheres);
		const double leaf = body.tree.meanGap;
		const auto row = [&](const char* how, const Pose& X) {
			const OverlapResult found = ask(body, body, X);
			const double sigma = overlapError(found, body.tree, body.tree, 1).volume, V = body.tree.volume;
			std::printf("two of %s %s: volume %.2f %% of the body's, off by %+.2f, sigma %.2f\n", name, how, 100 * found.total.volume / V,
				100 * (found.total.volume / V - commonShare(body.surface, bounds(mesh), X)), 100 * sigma / V);
		};
		const Vec3 axis = normalized(Vec3{1, 2, 3});
		row("in one place", {});
		for (const double degrees : {0.1, 1.0, 5.0})
		{
			char how[64];
			std::snprintf(how, sizeof how, "turned by %g degrees", degrees);
			row(how, {turned(kPi / 180 * degrees, axis), {}});
		}
		row("shifted by a mean gap", {{}, leaf * axis});
		row("shifted by three mean gaps", {{}, 3 * leaf * axis});
	}
}
}  // namespace

int main(int argc, char** argv)
{
	int64_t spheres = 1000;
	bool leaves = false;
	for (int i = 1; i < argc; ++i)
	{
		if (std::strcmp(argv[i], "--leaves") == 0) leaves = true;
		else if (std::strcmp(argv[i], "--spheres") == 0 && i + 1 < argc) spheres = std::atoll(argv[++i]);
		else return std::fprintf(stderr, "bench_shallow: unknown option %s\n", argv[i]), 2;
	}
	Bench bench(spheres, leaves);
	bench.flat();
	bench.announced("cubes of 0.2 m", makeBoxMesh({0.1, 0.1, 0.1}));
	bench.announced("tori of 0.3 / 0.1 m", makeTorusMesh(0.3, 0.1));
	bench.announced("spheres of 0.1 m", makeSphereMesh(0.1, 5));
	bench.pin();
	bench.floor();
	bench.inOnePlace();
	return 0;
}
