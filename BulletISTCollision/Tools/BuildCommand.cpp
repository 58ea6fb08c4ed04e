// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Commands.h"

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Base/ThreadCount.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/LengthUnit.h"
#include "BulletISTCollision/Core/Mesh/MeshDiagnostics.h"
#include "BulletISTCollision/Core/Platform/Utf8Path.h"
#include "BulletISTCollision/Core/Tuning/ExpectedError.h"
#include "BulletISTCollision/Tools/BuildProgress.h"
#include "BulletISTCollision/Tools/Interruption.h"
#include "BulletISTCollision/Tools/OutputFile.h"
#include "BulletISTCollision/Tools/Platform/PeakMemory.h"
#include "BulletISTCollision/Tools/ProgressBar.h"
#include "BulletISTCollision/Tools/Report.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ist::tools
{
namespace
{
/// Limit for builds that only --fill, --min-radius or --error end.
constexpr int64_t kMostSpheres = 5'000'000;

/// Share of the volume.
constexpr double kNoticedChange = 1e-3;

/// Without `whole`, the bar shows the progress of each stage.
Progress shown(ProgressBar& bar, const std::optional<BuildProgress>& whole, bool quiet)
{
	return [&bar, &whole, quiet](const char* stage, double fraction) {
		if (!quiet) whole ? bar.show(stage, fraction, whole->done(stage, fraction)) : bar.show(stage, fraction);
		return !interrupted();
	};
}

/// Whether the build has another limit than the number of spheres, so that this number is not known in advance.
bool otherLimit(const BuildArguments& a) { return a.fill > 0 || a.minRadius > 0 || a.error > 0; }

std::optional<BuildProgress> wholeBuild(const BuildArguments& a, double triangles)
{
	if (otherLimit(a)) return std::nullopt;
	return BuildProgress(triangles, double(a.spheres > 0 ? a.spheres : BuildOptions().maxSpheres), threadCount(a.threads));
}

double fileBytes(const std::string& path)
{
	std::error_code failure;
	const auto bytes = std::filesystem::file_size(systemPath(path), failure);
	return failure ? 0 : double(bytes);
}

BuildOptions buildOptions(const BuildArguments& a, double unit, const Progress& progress)
{
	BuildOptions options;
	options.maxSpheres = a.spheres > 0 ? a.spheres : otherLimit(a) ? kMostSpheres : options.maxSpheres;
	if (a.fill > 0) options.targetFill = a.fill;
	options.minRadius = a.minRadius;
	const RepairChoice repair = repairChoice(a.repair).value_or(RepairChoice());
	options.repair = repair.mode;
	options.ground = repair.ground;
	const bool namesAxis = std::count(a.repair.begin(), a.repair.end(), ' ') == 2;
	if (const auto axes = upAxes(a.up); axes && !namesAxis) options.ground.up = axes->to;
	options.unit = unit;
	options.seed = a.seed;
	options.surface = !a.withoutSurface;
	options.threads = a.threads;
	options.progress = progress;
	return options;
}

/// Shares of the volume that repair guessed: said from the first on, and refused from the second on.
constexpr double kSaidDoubt = 0.05, kMostDoubt = 0.5;

/// Sentences in one line, each after a blank.
std::string allOf(const std::vector<std::string>& sentences)
{
	std::string all;
	for (const std::string& sentence : sentences) all += " " + sentence;
	return all;
}

/// Warns with one line on stderr, in place of the report, if the packed body differs from what the file described, or may differ. Users
/// search the logs of build farms for such lines.
void warnOfRepair(const std::string& path, const Mesh& mesh, const InnerSphereTree& tree, double doubt)
{
	const double change = volumeChange(tree);
	if (mesh.notTaken.empty() && tree.provenance.watertight && std::fabs(change) <= kNoticedChange && doubt <= kSaidDoubt) return;
	char text[64] = "";
	if (std::isfinite(change)) std::snprintf(text, sizeof text, ", volume %+.3g %%", 100 * change);
	std::string line = "warning: " + path + ": repaired" + text;
	if (doubt > kSaidDoubt) line += ", " + ist::number(std::ceil(100 * doubt)) + " % of the volume is in doubt";
	fail(line + ":" + allOf(tree.provenance.repair), kGood);
}

double shareInDoubt(const RepairedMesh& repaired) { return repaired.volumeDoubt / repaired.volumeAfter; }

std::string doubtWords(const RepairedMesh& repaired)
{
	return "the volume of " + ist::number(repaired.volumeAfter) + " m^3 may be off by " + ist::number(repaired.volumeDoubt) + " m^3 (" +
		ist::number(std::ceil(100 * shareInDoubt(repaired))) + " %), because parts of the surface are missing or were rebuilt";
}
}  // namespace

int runBuild(const BuildArguments& a)
{
	if (const int code = checkOutput(a.output, {a.mesh}); code != kGood) return code;
	catchInterrupts();
	const auto start = std::chrono::steady_clock::now();
	const auto seconds = [start] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };

	ProgressBar bar;
	std::optional<BuildProgress> whole = wholeBuild(a, likelyTriangles(fileBytes(a.mesh)));
	const Progress progress = shown(bar, whole, a.quiet);
	const auto end = [&](bool good) {
		if (!good || !whole) bar.finish();
	};
	Result<Mesh> mesh = importMesh(a.mesh, lengthUnit(a.unit), progress);
	end(bool(mesh) && !interrupted());
	if (!mesh && mesh.error().cancelled) return fail("interrupted; nothing was written", kInterrupted);
	if (!mesh) return fail(mesh.error().message);
	if (interrupted()) return fail("interrupted; nothing was written", kInterrupted);
	mesh = turnedUp(std::move(mesh).value(), upAxes(a.up));
	const double importSeconds = seconds();
	whole = wholeBuild(a, double(mesh.value().triangles.size()));
	BuildTimes times;
	const BuildOptions options = buildOptions(a, mesh.value().unit, progress);
	const auto repairStart = seconds();
	Result<RepairedMesh> repaired = repairToBuild(mesh.value(), options);
	// The asset keeps this sentence, so that `ist info` says it, too.
	if (const auto axes = upAxes(a.up); repaired && axes && (axes->from.axis != axes->to.axis || axes->from.sign != axes->to.sign))
		repaired.value().actions.insert(repaired.value().actions.begin(),
			"Turned the axes: " + axisName(axes->from) + " of the file became " + axisName(axes->to) + ".");
	const double repairSeconds = seconds() - repairStart;
	// With --repair wrap the doubt comes from the cells of the grid alone, which the user asked for.
	if (repaired && shareInDoubt(repaired.value()) > kMostDoubt && !a.acceptDoubt && options.repair != RepairMode::Wrap)
	{
		end(false);
		return fail(a.mesh + ": " + doubtWords(repaired.value()) +
			"; close the mesh in a modelling program, rebuild it on a grid (--repair wrap), which takes what it surrounds for the body, or "
			"build it all the same (--accept-doubt)" +
			groundAdvice(mesh.value()) + ". The repair did this:" + allOf(repaired.value().actions));
	}
	const Result<InnerSphereTree> tree = !repaired ? Result<InnerSphereTree>(repaired.error())
		: a.error > 0                              ? buildRepairedToError(mesh.value(), repaired.value(), a.error, options, &times)
												   : buildRepaired(mesh.value(), repaired.value(), options, &times);
	end(bool(tree));
	if (!tree && tree.error().cancelled) return fail("interrupted; nothing was written", kInterrupted);
	if (!tree) return fail(a.mesh + ": " + tree.error().message);
	const Result<size_t> bytes = saveAsset(tree.value(), a.output, progress);
	bar.finish();
	if (!bytes) return fail(bytes.error().message, bytes.error().cancelled ? kInterrupted : kBadInput);
	const double doubt = shareInDoubt(repaired.value());
	if (doubt > kSaidDoubt && !a.quiet) fail("warning: " + a.mesh + ": " + doubtWords(repaired.value()), kGood);
	askAboutSize(a.mesh, tree.value().box.longestSide());
	if (a.quiet)
	{
		warnOfRepair(a.mesh, mesh.value(), tree.value(), doubt);
		return kGood;
	}

	Report report = newReport();
	describeTree(report, tree.value(), bytes.value());
	report["unit"] = unitName(tree.value().provenance.unit);
	report["volume_doubt"] = doubt;
	report["up"] = a.up.empty() ? Report() : Report(a.up);
	report["seconds"] = seconds();
	report["seconds_setup"] = importSeconds + repairSeconds + times.setup;
	report["seconds_packing"] = times.packing;
	report["seconds_leaves"] = times.leaves;
	report["seconds_surface"] = times.surface;
	report["seconds_tree"] = times.tree;
	report["peak_memory_bytes"] = static_cast<uint64_t>(peakMemoryBytes());
	std::fputs(format(report, a.json).c_str(), stdout);
	return kGood;
}
}  // namespace ist::tools
