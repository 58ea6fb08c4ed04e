// SPDX-License-Identifier: Zlib
#include "demos/scenes/Extremes/Continuity.h"

#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"
#include "BulletISTCollision/Json/JsonValue.h"
#include "TestSupport/SceneFiles/AssetCache.h"
#include "demos/scenes/Pages/TraceChart.h"
#include "demos/scenes/Truth/ContinuumGrid.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <optional>

using namespace ist;

namespace scenes
{
namespace
{
constexpr double kTick = 1e-3, kLongestSide = 0.2, kFast = 0.1, kSlow = 0.05, kCut = 50;  // [s], [m], [m/s], [m/s], [Hz]
constexpr double kPi = 3.14159265358979323846;

class PathWriter
{
public:
	PathWriter(const MeshDistance& surface, const RodProbe& rod) : m_surface(surface), m_rod(rod), m_box(bounds(surface.mesh())) {}

	/// Height at which the rod first touches when it descends at (x, z) with its axis along z.
	double touch(double x, double z) const
	{
		double y = m_box.upper.y + m_rod.radius + 0.01;
		for (int i = 0; i < 400 && y > m_box.lower.y; ++i)
		{
			double gap = 1e300;
			for (int s = -8; s <= 8; ++s)
				gap = std::min(gap, m_surface.signedDistance({x, y, z + m_rod.halfLength * s / 8}) - m_rod.radius);
			if (gap < 1e-6) break;
			y -= gap;
		}
		return y;
	}

	void phase(const char* name, bool touches)
	{
		if (!phases.empty()) phases.back().end = time();
		phases.push_back({name, time(), time(), touches});
	}
	void moveTo(const Vec3& target, double speed)
	{
		if (centers.empty())
		{
			centers.push_back(target);
			return;
		}
		const Vec3 from = centers.back();
		const int steps = std::max(1, static_cast<int>(std::ceil(distance(from, target) / (speed * kTick))));
		for (int i = 1; i <= steps; ++i) centers.push_back(from + (static_cast<double>(i) / steps) * (target - from));
	}
	void finish() { phases.back().end = time(); }

	std::vector<Vec3> centers;
	std::vector<ProbePhase> phases;

private:
	double time() const { return kTick * static_cast<double>(centers.empty() ? 0 : centers.size() - 1); }

	const MeshDistance& m_surface;
	RodProbe m_rod;
	Box m_box;
};

/// Straight lines at constant speed between points `depth` below the touching height. The force then depends on the surface and on no
/// controller.
PathWriter writePath(const MeshDistance& surface, const RodProbe& rod, double depth)
{
	PathWriter path(surface, rod);
	const Box box = bounds(surface.mesh());
	const double z = massProperties(surface.mesh()).centerOfMass.z;
	const auto pressed = [&](double share, double off) {
		const double x = box.lower.x + share * box.size().x;
		return Vec3{x, path.touch(x, z) + off, z};
	};
	const double clear = 0.002;
	path.phase("press", true);
	path.moveTo(pressed(0.66, clear), kFast);
	path.moveTo(pressed(0.66, -depth), kFast);
	path.phase("slide at 10 cm/s", true);
	for (const double at : {0.69, 0.72, 0.75, 0.78}) path.moveTo(pressed(at, -depth), kFast);
	path.phase("let go", false);
	path.moveTo(pressed(0.78, clear), kFast);
	path.moveTo(pressed(0.64, 0.01), kFast);
	path.phase("come back", true);
	path.moveTo(pressed(0.64, clear), kFast);
	path.moveTo(pressed(0.64, -depth), kFast);
	path.phase("slide at 5 cm/s", true);
	for (const double at : {0.67, 0.70, 0.73, 0.76}) path.moveTo(pressed(at, -depth), kSlow);
	path.phase("let go at last", false);
	path.moveTo(pressed(0.76, clear), kFast);
	path.finish();
	return path;
}

/// Grid of the cells that the rod meets on its way.
ContinuumGrid gridAlong(const std::vector<Vec3>& centers, const MeshDistance& surface, const RodProbe& rod, double spacing)
{
	Box swept{centers.front(), centers.front()};
	for (const Vec3& p : centers) swept = {componentMin(swept.lower, p), componentMax(swept.upper, p)};
	const double wide = rod.radius + 2 * spacing;
	const Vec3 margin{wide, wide, wide + rod.halfLength};
	// The rod moves at most 0.5 mm between the centres that are checked.
	const double reach = wide + 5e-4;
	const auto met = [&](const Vec3& p) {
		for (size_t i = 0; i < centers.size(); i += 5)
		{
			const Vec3 from = p - centers[i];
			const double along = std::max(0.0, std::fabs(from.z) - rod.halfLength);
			if (from.x * from.x + from.y * from.y + along * along < reach * reach) return true;
		}
		return false;
	};
	return ContinuumGrid(surface, {swept.lower - margin, swept.upper + margin}, spacing, met);
}

void compareSpectra(ContinuityOutcome& o)
{
	double mean = 0, powerFound = 0, powerTruth = 0;
	for (const ProbePhase& phase : o.phases)
	{
		if (phase.name != "slide at 5 cm/s") continue;
		std::vector<double> found[3], wanted[3];
		for (const ContinuityTick& t : o.ticks)
		{
			if (t.time < phase.begin || t.time > phase.end) continue;
			mean += norm(t.truth);
			for (int i = 0; i < 3; ++i) found[i].push_back(t.found[i]), wanted[i].push_back(t.truth[i]);
		}
		mean /= std::max(1.0, static_cast<double>(found[0].size()));
		for (int i = 0; i < 3; ++i)
		{
			powerFound += powerAbove(found[i], 1 / kTick, kCut);
			powerTruth += powerAbove(wanted[i], 1 / kTick, kCut);
		}
	}
	if (!(mean > 0)) return;
	o.powerFound = std::sqrt(powerFound) / mean;
	o.powerTruth = std::sqrt(powerTruth) / mean;
	o.excess = std::sqrt(std::max(0.0, powerFound - powerTruth)) / mean;
}

void summarise(ContinuityOutcome& o)
{
	double error = 0, truth = 0;
	for (const ContinuityTick& t : o.ticks)
	{
		o.largestForce = std::max(o.largestForce, norm(t.truth));
		error += squaredNorm(t.found - t.truth);
		truth += squaredNorm(t.truth);
	}
	if (!(truth > 0)) return;
	o.forceError = std::sqrt(error / truth);
	std::vector<double> changes;
	for (size_t i = 1; i < o.ticks.size(); ++i)
	{
		const Vec3 found = o.ticks[i].found - o.ticks[i - 1].found, wanted = o.ticks[i].truth - o.ticks[i - 1].truth;
		changes.push_back(norm(found - wanted) / o.largestForce);
		o.largestChange = std::max(o.largestChange, norm(wanted) / o.largestForce);
	}
	o.changeError = quantile(changes, 1);
	o.changeError99 = quantile(changes, 0.99);

	compareSpectra(o);
}
}  // namespace

double powerAbove(const std::vector<double>& values, double rate, double cut)
{
	const size_t n = values.size();
	if (n < 3) return 0;
	// A linear trend is subtracted first, because it is no oscillation and the window would smear it.
	const double first = values.front(), slope = (values.back() - first) / static_cast<double>(n - 1);
	std::vector<double> windowed(n);
	double weight = 0;
	for (size_t i = 0; i < n; ++i)
	{
		const double hann = 0.5 - 0.5 * std::cos(2 * kPi * static_cast<double>(i) / static_cast<double>(n));
		windowed[i] = hann * (values[i] - first - slope * static_cast<double>(i));
		weight += hann * hann;
	}
	double power = 0;
	for (size_t k = 1; 2 * k <= n; ++k)
	{
		if (rate * static_cast<double>(k) / static_cast<double>(n) <= cut) continue;
		std::complex<double> sum = 0;
		for (size_t i = 0; i < n; ++i)
			sum += windowed[i] * std::polar(1.0, -2 * kPi * static_cast<double>(k * i % n) / static_cast<double>(n));
		power += (2 * k == n ? 1 : 2) * std::norm(sum) / (static_cast<double>(n) * weight);
	}
	return power;
}

Result<ContinuityOutcome> runContinuity(const ContinuityOptions& options)
{
	const auto go = [&](const char* stage, double fraction) { return !options.progress || options.progress(stage, fraction); };
	const Result<Mesh> read = importMesh(options.mesh, std::nullopt, options.progress);
	if (!read) return read.error();
	Mesh mesh = turnedUp(read.value(), options.up);
	const double scale = kLongestSide / bounds(mesh).longestSide();
	for (Vec3& p : mesh.vertices) p *= scale;
	const Result<RepairedMesh> repaired = repair(mesh, RepairMode::Auto, options.progress);
	if (!repaired) return repaired.error();

	const RodProbe rod;
	BuildOptions build;
	build.maxSpheres = options.spheres;
	build.unit = scale * mesh.unit;
	build.progress = options.progress;
	const Result<CachedTree> body = treeFromCache(repaired.value().mesh, build, options.cache, "continuity-body", options.say);
	if (!body) return body.error();
	build.maxSpheres = options.rodSpheres;
	build.unit = 1;
	const Result<CachedTree> probe = treeFromCache(
		makeCapsuleMesh(rod.radius, rod.halfLength, 96), build, options.cache, "continuity-rod", options.say);
	if (!probe) return probe.error();

	const MeshDistance surface(repaired.value().mesh);
	const PathWriter path = writePath(surface, rod, options.depth);
	if (!go("grid", 0)) return Error{"the run was stopped", true};
	const ContinuumGrid grid = gridAlong(path.centers, surface, rod, options.spacing);

	ContinuityOutcome o;
	o.mesh = options.mesh;
	o.spheres = body.value().tree->spheres.size();
	o.phases = path.phases;
	o.ticks.resize(path.centers.size());
	QueryWorkspace workspace;
	for (size_t i = 0; i < o.ticks.size(); ++i)
	{
		ContinuityTick& t = o.ticks[i];
		t.time = kTick * static_cast<double>(i);
		t.center = path.centers[i];
		const OverlapResult found = queryOverlap(*body.value().tree, *probe.value().tree, {{}, t.center}, workspace);
		t.found = -1.0 * pressureWrench(found.total, {1, 0.5, 0.5}).force;
		t.foundVolume = found.total.volume;
		t.pairs = found.total.pairs;
		const ContinuumGrid::Sum truth = grid.overlap(rod, t.center, {0, 0, 1});
		t.truth = truth.onRod;
		t.trueVolume = truth.volume;
		if (i % 20 == 0 && !go("continuum", static_cast<double>(i) / static_cast<double>(o.ticks.size())))
			return Error{"the run was stopped", true};
	}
	summarise(o);
	return o;
}

std::vector<std::vector<std::string>> summaryRows(const ContinuityOutcome& o)
{
	const auto percent = [](double v) { return formatNumber(100 * v, 3); };
	return {{"Result", o.ok() ? "ok" : "FAILED: the rod met nothing", ""}, {"Spheres", std::to_string(o.spheres), ""},
		{"Ticks", std::to_string(o.ticks.size()), ""}, {"Force, rms error / rms truth", percent(o.forceError), "%"},
		{"Change per tick of the continuum, most, of the largest force", percent(o.largestChange), "%"},
		{"Change per tick, largest difference to the continuum's", percent(o.changeError), "%"},
		{"Change per tick, 99th percentile of the difference", percent(o.changeError99), "%"},
		{"Above 50 Hz at 5 cm/s, rms of the mean force, trees", percent(o.powerFound), "%"},
		{"Above 50 Hz at 5 cm/s, rms of the mean force, continuum", percent(o.powerTruth), "%"},
		{"Above 50 Hz at 5 cm/s, excess", percent(o.excess), "%"}};
}

HtmlReport makeReport(const ContinuityOutcome& o)
{
	HtmlReport report("Continuity of the force");
	report.paragraph(
		"A round rod, 50 mm long and 20 mm thick, is led over a body of spheres at 1 kHz: it presses, slides at 10 cm/s, lets go, comes "
		"back "
		"elsewhere and slides at 5 cm/s. The force of the trees is compared with that of the continuum, summed over a fine grid that "
		"stays with the body. Forces are per stiffness: 1 cm\xC2\xB3 at 1e6 Pa/m is 1 N.");
	report.table({"Quantity", "Value", "Unit"}, summaryRows(o));
	const std::vector<ContinuityTick>& ticks = o.ticks;
	const double largest = o.ok() ? o.largestForce : 1;
	const auto over = [&](std::function<double(size_t)> value) {
		return Trace{ticks.size(), [&ticks](size_t i) { return ticks[i].time; }, std::move(value)};
	};
	const auto change = [&](size_t i, bool found) {
		if (i == 0) return Vec3();
		return found ? ticks[i].found - ticks[i - 1].found : ticks[i].truth - ticks[i - 1].truth;
	};
	report.chart({"Force on the rod", "time [s]", "|force| / k [cm\xC2\xB3]",
		{envelope("trees", over([&](size_t i) { return 1e6 * norm(ticks[i].found); })),
			envelope("continuum", over([&](size_t i) { return 1e6 * norm(ticks[i].truth); }))}});
	report.chart({"Along the way (x)", "time [s]", "force / k [cm\xC2\xB3]",
		{envelope("trees", over([&](size_t i) { return 1e6 * ticks[i].found.x; })),
			envelope("continuum", over([&](size_t i) { return 1e6 * ticks[i].truth.x; }))}});
	report.chart({"Change of force from tick to tick", "time [s]", "of the largest force [%]",
		{envelope("continuum", over([&](size_t i) { return 100 * norm(change(i, false)) / largest; })),
			envelope("difference of trees and continuum",
				over([&](size_t i) { return 100 * norm(change(i, true) - change(i, false)) / largest; }))}});
	report.chart({"Overlap", "time [s]", "volume [mm\xC2\xB3]",
		{envelope("trees", over([&](size_t i) { return 1e9 * ticks[i].foundVolume; })),
			envelope("continuum", over([&](size_t i) { return 1e9 * ticks[i].trueVolume; }))}});
	return report;
}

std::string makeJson(const ContinuityOutcome& o)
{
	JsonValue json = {{"schema", 1}, {"demo", "continuity"}, {"ok", o.ok()}, {"spheres", o.spheres}, {"ticks", o.ticks.size()},
		{"force_error_rms", o.forceError}, {"largest_change", o.largestChange}, {"change_error", o.changeError},
		{"change_error_p99", o.changeError99}, {"above_50hz_found", o.powerFound}, {"above_50hz_truth", o.powerTruth},
		{"above_50hz_excess", o.excess}};
	return json.dump();
}
}  // namespace scenes
