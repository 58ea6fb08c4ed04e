// SPDX-License-Identifier: Zlib
// Measures the error of the model against quadrature on the triangles, and whether the reported sigma agrees with it. The cases are
// bodies against bodies at 0.1, 1 and 10 % overlap and bodies against half-spaces at some depths, all in seeded random poses.
// Usage: bench_truth [--spheres N=1000] [--poses N=10] [--directions N=40] [--lines N=120] [--points N=40000] [--only NAMES] [--csv
// FILE] [--levels 1] [--pairs compact]
// Lines and points are those of the quadrature; the last two columns are its own standard error. --levels adds the coarser levels of
// the same trees. --pairs thin measures pairs of thin bodies, and --pairs small a body with one that is 6 or 20 times smaller. Errors
// of the force are relative to it, or to a quarter of k V where opposing forces leave less.
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"
#include "demos/scenes/Truth/MeshBelowPlane.h"
#include "demos/scenes/Truth/OverlapQuadrature.h"
#include "demos/scenes/Truth/PoseSampler.h"
#include "tests/bench/bodies/BenchBodies.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

using namespace ist;
using bench::meshNamed, bench::placed;
using namespace scenes;

namespace
{
constexpr double kOverlaps[] = {0.001, 0.01, 0.1};
constexpr double kGaps[] = {1, 2, 4, 8};
constexpr double kCancelled = 0.25;              // smallest reference of a force error, as a share of k V with k = 1
constexpr double kShares[] = {0.01, 0.03, 0.1};  // shares of the longest side

struct Options
{
	int spheres = 1000, poses = 10, directions = 40, lines = 120, points = 40000;
	std::string only, csv, pairs = "compact";
	bool levels = false;
};

struct Body
{
	std::string name;
	Mesh mesh;
	InnerSphereTree tree;
};

/// Pairs of bodies to measure; "torus/6" is one sixth as large.
using Pairs = std::vector<std::array<std::string, 2>>;

Pairs pairsNamed(const std::string& name)
{
	if (name == "thin")
		return {{"plate", "bunny"}, {"rod", "jack"}, {"wire", "jack"}, {"crown", "bunny"}, {"sword", "torus"}, {"plate", "knot"}};
	if (name == "small")
		return {{"bunny", "torus/6"}, {"knot", "bunny/6"}, {"torus", "jack/6"}, {"bunny", "knot/20"}, {"jack", "bunny/20"}};
	if (name == "compact")
		return {{"bunny", "bunny"}, {"box", "bunny"}, {"torus", "torus"}, {"torus", "bunny"}, {"jack", "torus"}, {"knot", "bunny"},
			{"knot", "torus"}};
	return {};
}

/// Each body once, in order of appearance.
std::vector<std::string> bodiesOf(const Pairs& pairs)
{
	std::vector<std::string> names;
	for (const auto& pair : pairs)
		for (const std::string& name : pair)
			if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
	return names;
}

/// The result has no spheres if the mesh is missing.
Body makeBody(const std::string& name, int spheres)
{
	const size_t slash = name.find('/');
	Body body{name, meshNamed(name.substr(0, slash)), {}};
	if (body.mesh.triangles.empty())
	{
		std::printf("%s: skipped; apt-get install glmark2-data\n", name.c_str());
		return body;
	}
	body.mesh = placed(std::move(body.mesh));
	if (slash != std::string::npos)
		for (Vec3& p : body.mesh.vertices) p = p / std::atof(name.c_str() + slash + 1);
	BuildOptions options;
	options.surface = false;  // contact of leaves
	options.maxSpheres = spheres;
	Result<InnerSphereTree> tree = buildTree(body.mesh, options);
	if (!tree)
	{
		std::printf("%s: %s\n", name.c_str(), tree.error().message.c_str());
		return body;
	}
	body.tree = std::move(tree).value();
	return body;
}

void printLeaves(const Body& body)
{
	double densest = 0, sum = 0;
	int dense = 0;
	const double leaves = body.tree.law.ballCount();
	for (const MomentEllipsoid& b : body.tree.law.slots())
	{
		densest = std::max<double>(densest, b.density);
		sum += b.density;
		dense += b.density > 0.999f;
	}
	std::printf("%-9s %6zu spheres, %6.0f leaves, fill %.3f, mean gap %.5f, resolution %.5f; "
				"density mean %.3f, largest %.4g, at one %d\n",
		body.name.c_str(), body.tree.spheres.size(), leaves, body.tree.fill, body.tree.meanGap, body.tree.resolution, sum / leaves, densest,
		dense);
}

struct Sums
{
	int poses = 0, oneSigma = 0, twoSigma = 0, oneSigmaForce = 0, twoSigmaForce = 0;
	double volume = 0, bias = 0, cells = 0, force = 0, torque = 0, pairs = 0;
	double truthVolume = 0, truthForce = 0;  ///< sums of squares of the quadrature's own relative errors
	std::vector<double> angles;

	double rms(double squares) const { return 100 * std::sqrt(squares / std::max(1, poses)); }
	double percent(double sum) const { return 100 * sum / std::max(1, poses); }
};

void addSigma(Sums& sums, double volumeError, double forceError, const OverlapError& sigma)
{
	sums.oneSigma += volumeError <= sigma.volume;
	sums.twoSigma += volumeError <= 2 * sigma.volume;
	sums.oneSigmaForce += forceError <= sigma.force;
	sums.twoSigmaForce += forceError <= 2 * sigma.force;
}

struct TruePose
{
	Pose X;
	QuadratureTruth truth;
};

std::vector<TruePose> truePoses(const Body& A, const Body& B, double overlap, const Options& options)
{
	const OverlapQuadrature quadrature(A.mesh, B.mesh);
	std::vector<TruePose> poses;
	for (const Pose& X : posesAtOverlap(quadrature, overlap, options.poses, 11))
		poses.push_back({X, quadrature.integrate(X, A.tree.origin, options.lines, options.points)});
	return poses;
}

/// `csv`: receives one line per pose, or null.
Sums measurePair(const Body& A, const Body& B, const std::vector<TruePose>& poses, std::FILE* csv)
{
	QueryWorkspace workspace;
	Sums sums;
	for (const TruePose& at : poses)
	{
		QueryOptions cells;
		cells.model = Model::Cell;
		const OverlapResult answer = queryOverlap(A.tree, B.tree, at.X, workspace);
		const OverlapIntegrals law = answer.total;
		const double volume = law.volume / at.truth.volume - 1;
		const double ofCells = queryOverlap(A.tree, B.tree, at.X, workspace, cells).total.volume / at.truth.volume - 1;
		const Wrench expected = at.truth.wrench(), actual = pressureWrench(law, {});
		const double size = std::max(norm(expected.force), kCancelled * at.truth.volume), error = norm(actual.force - expected.force);
		if (csv)
			std::fprintf(csv, "%s-%s,%g,%lld,%g,%g,%g,%g,%g\n", A.name.c_str(), B.name.c_str(), at.truth.volume, (long long)law.pairs,
				volume, error / law.volume, norm(expected.force) / law.volume, leafDensity(answer, A.tree, B.tree) * law.volume,
				(A.tree.errorLength() + B.tree.errorLength()) * norm(law.areaVector) / law.volume);
		++sums.poses;
		sums.pairs += double(law.pairs);
		sums.bias += volume;
		sums.volume += volume * volume;
		sums.cells += ofCells * ofCells;
		sums.force += error * error / (size * size);
		sums.truthVolume += at.truth.volumeError * at.truth.volumeError / (at.truth.volume * at.truth.volume);
		sums.truthForce += at.truth.normalError * at.truth.normalError / (size * size);
		const double arm = size * std::min(A.tree.box.longestSide(), B.tree.box.longestSide());
		sums.torque += squaredNorm(actual.torque - expected.torque) / (arm * arm);
		sums.angles.push_back(
			180 / std::numbers::pi * std::atan2(norm(cross(actual.force, expected.force)), dot(actual.force, expected.force)));
		addSigma(sums, std::fabs(law.volume - at.truth.volume), error, overlapError(answer, A.tree, B.tree, 1));
	}
	std::sort(sums.angles.begin(), sums.angles.end());
	return sums;
}

/// Prints each level of the same trees, down to about 30 pairs.
void printLevels(const Body& A, const Body& B, double overlap, const std::vector<TruePose>& poses)
{
	QueryWorkspace workspace;
	for (int level = 0;; ++level)
	{
		Sums sums;
		QueryOptions options;
		options.level = level;
		for (const TruePose& at : poses)
		{
			const OverlapResult result = queryOverlap(A.tree, B.tree, at.X, workspace, options);
			if (result.status != QueryStatus::Ok || result.level != level) return;
			const Vec3 expected = at.truth.wrench().force;
			const double volume = result.total.volume / at.truth.volume - 1;
			++sums.poses;
			sums.pairs += double(result.total.pairs) / double(poses.size());
			sums.volume += volume * volume;
			const double size = std::max(norm(expected), kCancelled * at.truth.volume);
			sums.force += squaredNorm(pressureWrench(result.total, {}).force - expected) / (size * size);
		}
		if (sums.pairs < 30) return;
		std::printf("%-17s %6.1f%% level %2d: %8.0f pairs, V rms %6.2f %%, F rms %6.2f %%, times sqrt(pairs): %5.2f\n",
			(A.name + "-" + B.name).c_str(), 100 * overlap, level, sums.pairs, sums.rms(sums.volume), sums.rms(sums.force),
			sums.rms(sums.force) / 100 * std::sqrt(sums.pairs));
	}
}

void printPairHead()
{
	std::printf("\n%-17s %7s %5s %7s | %7s | %7s %7s %5s %5s | %7s %7s %5s %5s | %7s | %7s %7s\n", "rms in %", "overlap", "poses", "pairs",
		"cells V", "V bias", "V rms", "1 sig", "2 sig", "F rms", "deg", "1 sig", "2 sig", "T rms", "truth V", "truth F");
}

void printPair(const std::string& name, double overlap, const Sums& s)
{
	std::printf("%-17s %6.1f%% %5d %7.0f | %7.2f | %+7.2f %7.2f %5.0f %5.0f | %7.2f "
				"%7.2f %5.0f %5.0f | %7.2f | %7.2f %7.2f\n",
		name.c_str(), 100 * overlap, s.poses, s.pairs / std::max(1, s.poses), s.rms(s.cells), s.percent(s.bias), s.rms(s.volume),
		s.percent(s.oneSigma), s.percent(s.twoSigma), s.rms(s.force), s.angles.empty() ? 0 : s.angles[s.angles.size() / 2],
		s.percent(s.oneSigmaForce), s.percent(s.twoSigmaForce), s.rms(s.torque), s.rms(s.truthVolume), s.rms(s.truthForce));
	std::fflush(stdout);
}

/// The body is turned at random, with its lowest point `depth` below the plane y = 0.
Sums measureHalfSpace(const Body& body, double depth, int directions)
{
	QueryWorkspace workspace;
	Sums sums;
	for (int i = 0; i < directions; ++i)
	{
		const Pose X{rotationMatrix(randomRotation(uint64_t(100 + i))), {}};
		const double height = lowestPoint(body.mesh, X) + depth, truth = volumeBelow(body.mesh, X, height);
		const OverlapResult answer = queryHalfSpace(body.tree, transpose(X.rotation) * Vec3{0, 1, 0}, height, workspace);
		const OverlapIntegrals& law = answer.total;
		const double relative = law.volume / truth - 1;
		++sums.poses;
		sums.pairs += double(law.pairs);
		sums.bias += relative;
		sums.volume += relative * relative;
		addSigma(sums, std::fabs(law.volume - truth), 0, overlapError(answer, body.tree, 1));
	}
	return sums;
}

void printHalfSpace(const Body& body, double depth, int directions)
{
	const Sums s = measureHalfSpace(body, depth, directions);
	std::printf("%-9s %8.5f %6.1f %8.1f | %+8.1f %8.1f %5.0f %5.0f\n", body.name.c_str(), depth, depth / body.tree.meanGap,
		s.pairs / std::max(1, s.poses), s.percent(s.bias), s.rms(s.volume), s.percent(s.oneSigma), s.percent(s.twoSigma));
}

void printHalfSpaces(const Body& body, int directions)
{
	std::printf("\n%-9s %8s %6s %8s | %8s %8s %5s %5s\n", "half-space", "depth", "gaps", "leaves", "V bias %", "V rms %", "1 sig", "2 sig");
	for (const double gaps : kGaps) printHalfSpace(body, gaps * body.tree.meanGap, directions);
	for (const double share : kShares) printHalfSpace(body, share, directions);
	std::fflush(stdout);
}

Options parse(int argc, char** argv)
{
	Options options;
	for (int i = 1; i + 1 < argc; i += 2)
	{
		const std::string key = argv[i];
		if (key == "--spheres") options.spheres = std::atoi(argv[i + 1]);
		else if (key == "--poses") options.poses = std::atoi(argv[i + 1]);
		else if (key == "--directions") options.directions = std::atoi(argv[i + 1]);
		else if (key == "--lines") options.lines = std::atoi(argv[i + 1]);
		else if (key == "--points") options.points = std::atoi(argv[i + 1]);
		else if (key == "--levels") options.levels = std::atoi(argv[i + 1]) != 0;
		else if (key == "--pairs") options.pairs = argv[i + 1];
		else if (key == "--only") options.only = argv[i + 1];
		else if (key == "--csv") options.csv = argv[i + 1];
	}
	return options;
}
}  // namespace

int main(int argc, char** argv)
{
	const Options options = parse(argc, argv);
	const Pairs pairs = pairsNamed(options.pairs);
	if (pairs.empty()) return std::printf("--pairs compact, thin or small\n"), 1;
	std::vector<std::string> names = bodiesOf(pairs);
	if (options.pairs == "compact") names.insert(names.end(), {"ellipsoid", "ball"});  // for the half-spaces
	std::vector<Body> bodies;
	for (const std::string& name : names)
	{
		if (options.only.find(name) == std::string::npos && !options.only.empty()) continue;
		bodies.push_back(makeBody(name, options.spheres));
		if (options.levels) bodies.back().tree.levels = buildLevels(bodies.back().tree.law);
		if (bodies.back().tree.law.empty()) bodies.pop_back();
		else printLeaves(bodies.back());
	}
	if (options.directions > 0)
		for (const Body& body : bodies) printHalfSpaces(body, options.directions);
	if (options.poses <= 0) return 0;
	std::FILE* const csv = options.csv.empty() ? nullptr : std::fopen(options.csv.c_str(), "w");
	if (!options.csv.empty() && !csv) return std::printf("cannot write %s\n", options.csv.c_str()), 1;
	if (csv) std::fprintf(csv, "pair,volume,pairs,volume_error,force_error_over_kV,force_over_kV,leaves,gap_over_depth\n");
	printPairHead();
	const auto find = [&](const std::string& name) {
		return std::find_if(bodies.begin(), bodies.end(), [&](const Body& b) { return b.name == name; });
	};
	for (const auto& pair : pairs)
	{
		const auto A = find(pair[0]), B = find(pair[1]);
		if (A == bodies.end() || B == bodies.end()) continue;
		for (const double overlap : kOverlaps)
		{
			const std::vector<TruePose> poses = truePoses(*A, *B, overlap, options);
			printPair(A->name + "-" + B->name, overlap, measurePair(*A, *B, poses, csv));
			if (options.levels) printLevels(*A, *B, overlap, poses);
		}
	}
	if (csv) std::fclose(csv);
	return 0;
}
