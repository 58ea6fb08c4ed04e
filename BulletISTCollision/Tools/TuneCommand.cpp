// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Commands.h"

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Platform/Utf8Path.h"
#include "BulletISTCollision/Core/Tuning/TuneFigures.h"
#include "BulletISTCollision/Tools/Interruption.h"
#include "BulletISTCollision/Tools/NumberText.h"
#include "BulletISTCollision/Tools/Report.h"

#include <cstdio>
#include <filesystem>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

namespace ist::tools
{
namespace
{
bool goesOn(const char*, double) { return !interrupted(); }

/// An asset or a mesh at the path that the user named.
Result<TuneBody> bodyOf(const std::string& path)
{
	TuneBody body{path, std::nullopt, {}};
	const std::string end = utf8Path(systemPath(path).extension());
	if (end == ".ist" || end == ".ista")
	{
		Result<InnerSphereTree> tree = loadAsset(path);
		if (!tree) return tree.error();
		body.tree = std::move(tree).value();
		return body;
	}
	Result<Mesh> mesh = importMesh(path, std::nullopt, goesOn);
	if (!mesh) return mesh.error();
	warnOfNotTaken(path, mesh.value());
	body.mesh = std::move(mesh).value();
	return body;
}

template <class Figures> void add(Report& report, const Figures& figures)
{
	eachFigure(figures, [&](const char* name, const auto& value) {
		if constexpr (std::is_same_v<decltype(value), const std::optional<double>&>) report[name] = value ? Report(*value) : Report();
		else report[name] = value;
	});
}

Report describe(const PairTuning& tuning)
{
	Report report = newReport();
	add(report, tuning);
	Report alternatives = Report::list();
	for (const TuneSetting& setting : tuning.alternatives) add(alternatives.append(), setting);
	report["alternatives"] = alternatives;
	return report;
}
}  // namespace

int runTune(const TuneArguments& a)
{
	catchInterrupts();
	std::vector<TuneBody> bodies;
	for (const std::string& file : {a.fileA, a.fileB})
	{
		if (!bodies.empty() && file == bodies.front().name) continue;
		Result<TuneBody> body = bodyOf(file);
		if (!body && body.error().cancelled) return fail("interrupted", kInterrupted);
		if (!body) return fail(body.error().message);
		bodies.push_back(std::move(body).value());
	}
	TuneOptions options = a.options;
	options.progress = goesOn;
	const Result<PairTuning> tuning = tunePair(bodies.front(), bodies.back(), options);
	if (!tuning) return interrupted() ? fail("interrupted", kInterrupted) : fail(tuning.error().message);
	std::fputs(format(describe(tuning.value()), a.json).c_str(), stdout);
	if (tuning.value().kept) return kGood;
	return fail("a force error of " + numberText(options.error) + " is out of reach of these trees: " +
		numberText(tuning.value().best.error) + " is the smallest error bound; build them with more spheres, or accept more");
}
}  // namespace ist::tools
