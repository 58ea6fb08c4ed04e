// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Commands.h"

#include "BulletISTCollision/Core/AssetFile.h"
#include "BulletISTCollision/Core/LevelCalibration.h"
#include "BulletISTCollision/Core/MeshImport.h"
#include "BulletISTCollision/Core/TreeBuilder.h"
#include "BulletISTCollision/Tools/Interruption.h"
#include "BulletISTCollision/Tools/NumberText.h"
#include "BulletISTCollision/Tools/Report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

namespace ist::tools
{
namespace
{
constexpr int64_t kFirstSpheres = 1000, kSpheresStep = 3;

/// A body as the user named it: an asset, or a mesh of which trees are built.
struct Source
{
	std::string path;
	std::optional<Mesh> mesh;
	InnerSphereTree tree;
};

Result<Source> sourceOf(const std::string& path)
{
	Source source{path, std::nullopt, {}};
	const std::string end = std::filesystem::path(path).extension().string();
	if (end == ".ist" || end == ".ista")
	{
		Result<InnerSphereTree> tree = loadAsset(path);
		if (!tree) return tree.error();
		source.tree = std::move(tree).value();
		addLevels(source.tree);
		return source;
	}
	Result<Mesh> mesh = importMesh(path);
	if (!mesh) return mesh.error();
	source.mesh = std::move(mesh).value();
	return source;
}

/// Empty when there is a tree of so many spheres.
std::string rebuild(Source& source, int64_t spheres)
{
	if (!source.mesh) return {};
	BuildOptions options;
	options.maxSpheres = spheres;
	options.progress = [](const char*, double) { return !interrupted(); };
	Result<InnerSphereTree> tree = buildTree(*source.mesh, options);
	if (!tree) return source.path + ": " + tree.error().message;
	source.tree = std::move(tree).value();
	addLevels(source.tree);
	return {};
}

Report describe(const TuneSetting& setting, const InnerSphereTree& A, const InnerSphereTree& B)
{
	Report r;
	r["spheres"] = std::max(A.spheres.size(), B.spheres.size());
	r["level"] = setting.level < 0 ? Report("by pose") : Report(setting.level);
	r["error"] = setting.error;
	r["time_us"] = setting.microseconds;
	r["pairs"] = setting.pairs;
	r["patches"] = setting.patches;
	return r;
}

Report describe(const WorldNeeds& needs)
{
	const auto finite = [](double value) { return std::isfinite(value) ? Report(value) : Report(); };
	Report r;
	r["precision"] = needs.inDouble ? "double" : "float";
	r["substeps"] = needs.substeps;
	r["rate_hz"] = 1 / needs.stepNeeded;
	r["explicit"] = needs.explicitWill;
	r["rest_depth_m"] = needs.restDepth;
	r["frequency_rad_s"] = needs.frequency;
	r["explicit_step_s"] = needs.explicitStep;
	r["restitution_step_s"] = finite(needs.restitutionStep);
	r["thickness_step_s"] = finite(needs.thicknessStep);
	return r;
}

/// Trees of more and more spheres where a body is a mesh, until a level promises the error.
class Tuning
{
public:
	/// One source: the body meets itself.
	Tuning(const TuneArguments& arguments, std::vector<Source> sources) : m_arguments(arguments), m_sources(std::move(sources)) {}

	int run()
	{
		const bool builds = std::any_of(m_sources.begin(), m_sources.end(), [](const Source& s) { return s.mesh.has_value(); });
		for (int64_t spheres = std::min(kFirstSpheres, m_arguments.spheres);; spheres = std::min(kSpheresStep * spheres, m_arguments.spheres))
		{
			for (Source& source : m_sources)
				if (const std::string problem = rebuild(source, spheres); !problem.empty()) return ended(problem);
			const Result<TuneSettings> found = measureSettings(A(), B(), m_arguments.error);
			if (!found) return ended(found.error().message);
			const bool kept = take(found.value().settings);
			if (!kept && builds && spheres < m_arguments.spheres) continue;
			if (const std::string problem = addWorld(found.value().contacts); !problem.empty()) return fail(problem);
			return print();
		}
	}

private:
	const InnerSphereTree& A() const { return m_sources.front().tree; }
	const InnerSphereTree& B() const { return m_sources.back().tree; }
	static int ended(const std::string& problem) { return interrupted() ? fail("interrupted", kInterrupted) : fail(problem); }

	/// True when a fixed level promises the error: the cheapest that does is the answer so far, else the one of the smallest error.
	bool take(const std::vector<TuneSetting>& settings)
	{
		const auto keeps = [&](const TuneSetting& s) { return s.error <= m_arguments.error; };
		const auto better = [&](const TuneSetting& a, const TuneSetting& b)
		{ return keeps(a) != keeps(b) ? keeps(a) : keeps(a) ? a.microseconds < b.microseconds : a.error < b.error; };
		const auto best = std::min_element(settings.begin(), settings.end() - 1, better);
		m_answer = newReport();
		m_answer.update(describe(*best, A(), B()));
		m_answer["spheres_a"] = A().spheres.size();
		m_answer["spheres_b"] = B().spheres.size();
		m_answer["kept"] = m_kept = keeps(*best);
		for (const TuneSetting& setting : settings) m_alternatives.push_back(describe(setting, A(), B()));
		return m_kept;
	}

	/// Empty when it was not asked for, or was found.
	std::string addWorld(const std::vector<TuneContact>& contacts)
	{
		const WorldSetup& world = m_arguments.world;
		if (!world.stiffness && !world.mass) return {};
		const Result<WorldNeeds> needs = worldNeeds(world, A(), B(), contacts, m_arguments.error);
		if (!needs) return needs.error().message;
		m_answer.update(describe(needs.value()));
		return {};
	}

	int print()
	{
		m_answer["alternatives"] = m_alternatives;
		std::fputs(format(m_answer, m_arguments.json).c_str(), stdout);
		if (m_kept) return kGood;
		return fail("a force error of " + numberText(m_arguments.error) + " is out of reach of these trees: " + numberText(m_answer["error"].get<double>()) +
					" is promised; build them with more spheres, or accept more");
	}

	const TuneArguments& m_arguments;
	std::vector<Source> m_sources;
	Report m_answer, m_alternatives = Report::array();
	bool m_kept = false;
};
}  // namespace

int runTune(const TuneArguments& a)
{
	catchInterrupts();
	std::vector<Source> sources;
	for (const std::string& file : {a.fileA, a.fileB})
	{
		if (!sources.empty() && file == sources.front().path) continue;
		Result<Source> source = sourceOf(file);
		if (!source) return fail(source.error().message);
		sources.push_back(std::move(source).value());
	}
	return Tuning(a, std::move(sources)).run();
}
}  // namespace ist::tools
