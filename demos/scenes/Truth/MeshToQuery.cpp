// SPDX-License-Identifier: Zlib
#include "demos/scenes/Truth/MeshToQuery.h"

#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"
#include "demos/scenes/Truth/OverlapQuadrature.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

using namespace ist;

namespace scenes
{
namespace
{
double secondsSince(std::chrono::steady_clock::time_point start)
{
	return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Largest height at which a point on the vertical through (x, z) is at the distance `reach` from the surface; at least `bottom`. For a
/// ball, `reach` is its radius minus the depth.
double contactHeight(const MeshDistance& surface, double x, double z, double top, double bottom, double reach)
{
	double y = top;
	while (y > bottom)
	{
		const double gap = surface.signedDistance({x, y, z}) - reach;
		if (gap < 1e-7) break;
		y -= gap;  // the signed distance is 1-Lipschitz, so this step never goes too far
	}
	return std::max(y, bottom);
}

/// Path of the probe: down in a quarter of the steps, along x over the middle half of the body, up in an eighth of the steps.
std::vector<Vec3> probePath(const MeshDistance& surface, const MeshToQueryOptions& options)
{
	const Box box = bounds(surface.mesh());
	const double reach = options.probeRadius - options.depth, lift = 2.5 * options.depth;
	const double z = massProperties(surface.mesh()).centerOfMass.z;
	const auto along = [&](double s) {
		const double x = box.lower.x + (0.25 + 0.5 * s) * box.size().x;
		return Vec3{x, contactHeight(surface, x, z, box.upper.y + 2 * options.probeRadius, box.lower.y, reach), z};
	};
	const int down = options.steps / 4, up = options.steps / 8, slide = options.steps - down - up;
	std::vector<Vec3> path;
	for (int i = 0; i < down; ++i) path.push_back(along(0) + Vec3{0, lift * (1 - static_cast<double>(i) / down), 0});
	for (int i = 0; i < slide; ++i) path.push_back(along(static_cast<double>(i) / std::max(1, slide - 1)));
	for (int i = 0; i < up; ++i) path.push_back(along(1) + Vec3{0, lift * (i + 1.0) / up, 0});
	return path;
}

Pose probePose(const Vec3& center)
{
	Pose X;
	X.translation = center;
	return X;
}

std::vector<PathStep> runPath(const InnerSphereTree& body, const InnerSphereTree& probe, const std::vector<Vec3>& path, double stiffness)
{
	QueryWorkspace workspace;
	const PressurePair pair{stiffness, 0.5, 0.5};
	std::vector<PathStep> steps;
	for (const Vec3& center : path)
	{
		const Pose X = probePose(center);
		const auto start = std::chrono::steady_clock::now();
		const OverlapResult found = queryOverlap(body, probe, X, workspace);
		const double seconds = secondsSince(start);
		steps.push_back({center, found.total.volume, norm(pressureWrench(found.total, pair).force),
			overlapError(found, body, probe, stiffness), found.total.pairs, seconds});
	}
	return steps;
}

std::vector<Comparison> compare(const OverlapQuadrature& quadrature, const InnerSphereTree& body, const InnerSphereTree& probe,
	const std::vector<PathStep>& steps, const MeshToQueryOptions& options)
{
	std::vector<int> touching;
	for (size_t i = 0; i < steps.size(); ++i)
		if (steps[i].volume > 0) touching.push_back(static_cast<int>(i));
	std::vector<Comparison> comparisons;
	const int count = std::min(options.comparisons, static_cast<int>(touching.size()));
	const PressurePair pair{options.stiffness, 0.5, 0.5};
	QueryWorkspace workspace;
	for (int c = 0; c < count; ++c)
	{
		if (options.progress && !options.progress("quadrature", static_cast<double>(c) / count)) break;
		const int step = touching[(2 * c + 1) * touching.size() / (2 * count)];
		const Pose X = probePose(steps[step].probe);
		const QuadratureTruth truth = quadrature.integrate(X, body.origin, 150, 60000);
		if (truth.volume <= 0) continue;
		const Vec3 expected = options.stiffness * truth.wrench().force;
		const Vec3 found = pressureWrench(queryOverlap(body, probe, X, workspace).total, pair).force;
		comparisons.push_back({step, truth.volume, norm(expected), steps[step].volume - truth.volume, norm(found - expected)});
	}
	return comparisons;
}

void summarise(MeshToQueryOutcome& outcome)
{
	std::vector<double> seconds;
	for (const PathStep& step : outcome.steps)
	{
		if (step.pairs > 0) seconds.push_back(step.seconds);
		outcome.maxPairs = std::max(outcome.maxPairs, step.pairs);
		outcome.maxForce = std::max(outcome.maxForce, step.force);
	}
	std::sort(seconds.begin(), seconds.end());
	if (!seconds.empty())
	{
		outcome.medianSeconds = seconds[seconds.size() / 2];
		outcome.p99Seconds = seconds[std::min(seconds.size() - 1, seconds.size() * 99 / 100)];
	}
	double volume = 0, volumeTruth = 0, force = 0, forceTruth = 0;
	for (const Comparison& c : outcome.comparisons)
	{
		volume += c.volumeError * c.volumeError;
		volumeTruth += c.volumeTruth * c.volumeTruth;
		force += c.forceError * c.forceError;
		forceTruth += c.forceTruth * c.forceTruth;
	}
	if (volumeTruth > 0) outcome.volumeRms = std::sqrt(volume / volumeTruth);
	if (forceTruth > 0) outcome.forceRms = std::sqrt(force / forceTruth);
}
}  // namespace

Result<MeshToQueryOutcome> runMeshToQuery(const MeshToQueryOptions& options)
{
	Result<Mesh> imported = importMesh(options.mesh, options.unit > 0 ? std::optional(options.unit) : std::nullopt);
	if (!imported) return imported.error();
	Mesh mesh = turnedUp(std::move(imported).value(), options.up);
	MeshToQueryOutcome outcome;
	outcome.mesh = options.mesh;
	const double scale = options.unit > 0 ? 1 : 0.2 / bounds(mesh).longestSide();
	outcome.unit = scale * mesh.unit;
	outcome.stiffness = options.stiffness;
	for (Vec3& p : mesh.vertices) p *= scale;

	BuildOptions build;
	build.maxSpheres = options.spheres;
	build.unit = outcome.unit;
	build.progress = options.progress;
	const auto start = std::chrono::steady_clock::now();
	const Result<InnerSphereTree> body = buildTree(mesh, build);
	outcome.buildSeconds = secondsSince(start);
	if (!body) return body.error();
	build.unit = 1;
	const Mesh ball = makeSphereMesh(options.probeRadius);
	const Result<InnerSphereTree> probe = buildTree(ball, build);
	if (!probe) return probe.error();
	Result<RepairedMesh> repaired = repair(mesh);
	if (!repaired) return repaired.error();

	const InnerSphereTree& tree = body.value();
	outcome.triangles = repaired.value().mesh.triangles.size();
	outcome.spheres = tree.spheres.size();
	outcome.leaves = tree.law.ballCount();
	outcome.fill = tree.fill;
	outcome.meanGap = tree.meanGap;
	outcome.repair = tree.provenance.repair;
	const OverlapQuadrature quadrature(repaired.value().mesh, ball);
	const std::vector<Vec3> path = probePath(MeshDistance(std::move(repaired).value().mesh), options);
	runPath(tree, probe.value(), path, options.stiffness);  // this run warms the caches
	outcome.steps = runPath(tree, probe.value(), path, options.stiffness);
	outcome.comparisons = compare(quadrature, tree, probe.value(), outcome.steps, options);
	summarise(outcome);
	return outcome;
}

std::vector<std::vector<std::string>> summaryRows(const MeshToQueryOutcome& outcome)
{
	return {{"Triangles", std::to_string(outcome.triangles), ""}, {"Spheres", std::to_string(outcome.spheres), ""},
		{"Leaves", std::to_string(outcome.leaves), ""}, {"Fill", formatNumber(100 * outcome.fill, 3), "%"},
		{"Mean gap", formatNumber(1e3 * outcome.meanGap, 3), "mm"}, {"Build", formatNumber(outcome.buildSeconds, 3), "s"},
		{"Query, median", formatNumber(1e6 * outcome.medianSeconds, 3), "us"},
		{"Query, 99th percentile", formatNumber(1e6 * outcome.p99Seconds, 3), "us"},
		{"Intersecting pairs, most", std::to_string(outcome.maxPairs), ""},
		{"Force, largest (k = " + formatNumber(outcome.stiffness, 3) + " Pa/m)", formatNumber(outcome.maxForce, 3), "N"},
		{"Volume, rms error / rms truth of " + std::to_string(outcome.comparisons.size()), formatNumber(100 * outcome.volumeRms, 2), "%"},
		{"Force, rms error / rms truth of " + std::to_string(outcome.comparisons.size()), formatNumber(100 * outcome.forceRms, 2), "%"}};
}

HtmlReport makeReport(const MeshToQueryOutcome& outcome)
{
	ChartSeries volume{"inner sphere tree", {}, {}, {}, false}, force = volume, pairs{"pairs", {}, {}, {}, false},
																time{"query", {}, {}, {}, false};
	for (size_t i = 0; i < outcome.steps.size(); ++i)
	{
		const PathStep& step = outcome.steps[i];
		for (ChartSeries* series : {&volume, &force, &pairs, &time}) series->x.push_back(static_cast<double>(i));
		volume.y.push_back(1e9 * step.volume);
		force.y.push_back(step.force);
		pairs.y.push_back(static_cast<double>(step.pairs));
		time.y.push_back(1e6 * step.seconds);
	}
	ChartSeries volumeTruth{"quadrature", {}, {}, {}, true}, forceTruth = volumeTruth;
	ChartSeries volumeError{"volume", {}, {}, {}, true}, forceError{"force, length of the difference", {}, {}, {}, true};
	for (const Comparison& c : outcome.comparisons)
	{
		const OverlapError& sigma = outcome.steps[c.step].sigma;
		for (ChartSeries* series : {&volumeTruth, &forceTruth, &volumeError, &forceError}) series->x.push_back(c.step);
		volumeTruth.y.push_back(1e9 * c.volumeTruth);
		forceTruth.y.push_back(c.forceTruth);
		volumeError.y.push_back(100 * c.volumeError / c.volumeTruth);
		volumeError.sigma.push_back(100 * sigma.volume / c.volumeTruth);
		forceError.y.push_back(100 * c.forceError / c.forceTruth);
		forceError.sigma.push_back(100 * sigma.force / c.forceTruth);
	}
	HtmlReport report("From a mesh to a contact force");
	report.paragraph(
		"A closed triangle mesh was filled with spheres and turned into a tree. A round probe then came down on it, slid along x over "
		"its back, and left. Every step is one overlap query; the dots are an independent integration over the triangles themselves.");
	report.heading("Summary");
	report.table({"Quantity", "Value", "Unit"}, summaryRows(outcome));
	for (const std::string& action : outcome.repair) report.paragraph("Repair: " + action);
	report.heading("Contact");
	report.chart({"Overlap volume", "step", "volume [mm\xC2\xB3]", {volume, volumeTruth}});
	report.chart({"Contact force", "step", "|force| [N]", {force, forceTruth}});
	report.heading("Accuracy");
	report.paragraph(
		"Relative errors at the compared steps. The bars are the standard errors that the library itself predicts, one sigma.");
	report.chart({"Errors against quadrature", "step", "error [%]", {volumeError, forceError}});
	report.heading("Work");
	report.chart({"Intersecting pairs", "step", "pairs", {pairs}});
	report.chart({"Query time", "step", "time [\xC2\xB5s]", {time}});
	return report;
}

std::string makeJson(const MeshToQueryOutcome& o)
{
	const auto field = [](const char* name, double value) { return std::string(",\"") + name + "\":" + formatNumber(value, 9); };
	std::string out = "{\"schema\":1,\"demo\":\"bunny-query\",\"ok\":" + std::string(o.ok() ? "true" : "false") + field("unit", o.unit) +
		field("triangles", static_cast<double>(o.triangles)) + field("spheres", static_cast<double>(o.spheres)) +
		field("leaves", static_cast<double>(o.leaves)) + field("fill", o.fill) + field("mean_gap_m", o.meanGap) +
		field("build_s", o.buildSeconds) + field("query_median_s", o.medianSeconds) + field("query_p99_s", o.p99Seconds) +
		field("max_pairs", static_cast<double>(o.maxPairs)) + field("stiffness_pa_per_m", o.stiffness) + field("max_force_n", o.maxForce) +
		field("volume_error_rms", o.volumeRms) + field("force_error_rms", o.forceRms) + ",\"comparisons\":[";
	for (size_t i = 0; i < o.comparisons.size(); ++i)
	{
		const Comparison& c = o.comparisons[i];
		out += (i ? ",{" : "{") + ("\"step\":" + std::to_string(c.step)) + field("volume_m3", c.volumeTruth) +
			field("volume_error_m3", c.volumeError) + field("force_n", c.forceTruth) + field("force_error_n", c.forceError) + "}";
	}
	return out + "]}";
}
}  // namespace scenes
