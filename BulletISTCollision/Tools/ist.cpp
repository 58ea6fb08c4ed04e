// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Commands.h"

#include "BulletISTCollision/Core/Base/Version.h"
#include "BulletISTCollision/Core/Mesh/LengthUnit.h"
#include "BulletISTCollision/Core/Platform/CommandProcess.h"
#include "BulletISTCollision/Tools/IntegerArgument.h"
#include "BulletISTCollision/Tools/UnknownCommand.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace ist::tools
{
namespace
{
constexpr const char* kVersion = "ist " BULLETHAPTICS_VERSION;

class CommandLine
{
public:
	CommandLine()
	{
		m_app.require_subcommand(1);
		m_app.set_version_flag("--version", kVersion);
		addBuild();
		addInfo();
		addCheck();
		addExport();
		addPack();
		addQuery();
		addTune();
	}

	int run(const std::vector<std::string>& given)
	{
		if (given.size() > 1)
			if (const std::string sentence = unknownCommand(given[1], commands()); !sentence.empty()) return fail(sentence, kUsage);
		try
		{
			m_app.parse(arguments(given));
		}
		catch (const CLI::ParseError& e)
		{
			return m_app.exit(e) == 0 ? kGood : kUsage;
		}
		const int code = m_command();
		const bool printed = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
		return printed || code != kGood ? code : fail("standard output cannot be written");
	}

private:
	std::vector<std::string> commands() const
	{
		std::vector<std::string> names;
		for (const CLI::App* sub : m_app.get_subcommands([](const CLI::App*) { return true; })) names.push_back(sub->get_name());
		return names;
	}

	/// The arguments in the order that CLI11 wants, last first. The depth of `--repair ground 2` becomes a part of its value: an option
	/// with a second value that may be missing would take the mesh for it.
	static std::vector<std::string> arguments(const std::vector<std::string>& given)
	{
		std::vector<std::string> result;
		for (size_t i = 1; i < given.size(); ++i)
		{
			result.push_back(given[i]);
			const bool isGround = result.back() == "--repair=ground" || (result.back() == "ground" && given[i - 1] == "--repair");
			if (isGround && i + 1 < given.size() && repairChoice("ground " + given[i + 1])) result.back() += " " + given[++i];
		}
		std::reverse(result.begin(), result.end());
		return result;
	}

	CLI::App* add(const char* name, const char* description, std::function<int()> command)
	{
		CLI::App* sub = m_app.add_subcommand(name, description);
		sub->set_version_flag("--version", kVersion);
		sub->callback([this, command] { m_command = command; });
		return sub;
	}

	void addBuild()
	{
		CLI::App* sub = add("build", "Pack a mesh and write its inner sphere tree", [this] { return runBuild(m_build); });
		BuildArguments& a = m_build;
		sub->add_option("mesh", a.mesh, "mesh file")->required();
		sub->add_option("-o,--output", a.output, "asset to write")->required();
		sub->add_option("--spheres", a.spheres, "most spheres (10000 when no limit is given)")
			->transform(integerArgument<int64_t>(1, 100000000));
		sub->add_option("--fill", a.fill, "stop at this share of the volume, 0..1")->check(fraction());
		sub->add_option("--min-radius", a.minRadius, "smallest radius [m]")->check(positive());
		sub->add_option("--error", a.error, "force error at 1 % overlap by the tree's own error bar, 0..1")->check(fraction());
		sub->add_option(
			   "--unit", a.unit, "length unit of the mesh file, in place of the one that it states: m, cm, mm, um, in, ft, or metres")
			->check(unit());
		sub->add_option("--up", a.up, "the file's axis that points up, which becomes y: z or -x, or z,y with another axis to become")
			->check(axes());
		sub->add_option("--repair", a.repair,
			   "what to do about broken meshes: auto, off, wrap, ground DEPTH [m], or \"ground DEPTH AXIS\" of the turned mesh")
			->check(repairs())
			->capture_default_str();
		sub->add_flag("--accept-doubt", a.acceptDoubt, "also build what repair may have guessed by more than half of the volume");
		sub->add_option("--threads", a.threads, "threads (all)")->transform(integerArgument(1, 4096));
		sub->add_flag("--no-surface", a.withoutSurface, "without the surface: shallow queries are faster, and wrong below the gaps");
		sub->add_option("--seed", a.seed, "seed")->transform(integerArgument<uint64_t>(0))->capture_default_str();
		sub->add_flag("--json", a.json, "one JSON object");
		sub->add_flag("--quiet", a.quiet, "no progress and no report, only a warning of a mesh that repair changed");
	}

	void addInfo()
	{
		CLI::App* sub = add("info", "Describe an asset", [this] { return runInfo(m_info); });
		sub->add_option("file", m_info.file, "asset")->required();
		sub->add_flag("--json", m_info.json, "one JSON object");
	}

	void addCheck()
	{
		CLI::App* sub = add(
			"check", "Prove that no spheres overlap and, with the mesh, that none protrudes", [this] { return runCheck(m_check); });
		sub->add_option("file", m_check.file, "asset")->required();
		sub->add_option("--mesh", m_check.mesh, "the mesh it was built from");
		sub->add_flag("--json", m_check.json, "one JSON object");
	}

	void addExport()
	{
		CLI::App* sub = add("export", "Write spheres or leaves as CSV", [this] { return runExport(m_export); });
		sub->add_option("file", m_export.file, "asset")->required();
		CLI::Option_group* what = sub->add_option_group("what");
		what->add_option("--spheres", m_export.spheres, "CSV of the packed spheres; - for standard output");
		what->add_option("--leaves", m_export.leaves, "CSV of the leaves; - for standard output");
		what->require_option(1, 2);
	}

	void addPack()
	{
		CLI::App* pack = add(
			"pack", "Write an archive: about a quarter of the size, and slower to load", [this] { return runPack(m_pack); });
		CLI::App* unpack = add("unpack", "Write the asset of an archive", [this] { return runUnpack(m_pack); });
		for (CLI::App* sub : {pack, unpack})
		{
			sub->add_option("input", m_pack.input, "file to read")->required();
			sub->add_option("-o,--output", m_pack.output, "file to write")->required();
			sub->add_flag("--json", m_pack.json, "one JSON object");
		}
	}

	void addQuery()
	{
		CLI::App* sub = add("query", "Overlap, force and distance of two bodies", [this] { return runQuery(m_query); });
		QueryArguments& a = m_query;
		sub->add_option("A", a.fileA, "asset of A")->required();
		sub->add_option("B", a.fileB, "asset of B")->required();
		CLI::Option_group* poses = sub->add_option_group("poses");
		poses->add_option("--pose", a.pose, "tx,ty,tz,qx,qy,qz,qw: B in A's mesh frame");
		poses->add_option("--poses", a.poses, "CSV of poses");
		poses->require_option(0, 1);  // runQuery() looks at the trees first: whoever passes two meshes has no pose yet
		sub->add_option("--law", a.law, "force law")
			->check(CLI::IsMember({"pressure", "paper", "energy", "volume"}))
			->capture_default_str();
		sub->add_option("--stiffness", a.stiffness, "k of the pair [Pa/m]")->check(positive())->capture_default_str();
		sub->add_option("--level", a.level, "level of the trees")->transform(integerArgument(0));
		sub->add_option("--max-pairs", a.maxPairs, "budget of pairs")->transform(integerArgument<int64_t>(0));
		sub->add_option("--error", a.error,
			   "force error accepted, 0..1: the coarsest level whose error bound is within it; the bound is printed, too")
			->check(fraction());
		sub->add_flag("--blend", a.blend, "within a budget, levels fade into each other");
		sub->add_flag("--gate", a.gate, "nothing while the packed spheres are apart");
		sub->add_flag("--lower-bound", a.lowerBound, "also a lower bound of the volume");
		sub->add_option("--threads", a.threads, "threads over rows")->transform(integerArgument(1, 4096))->capture_default_str();
		sub->add_option("--repeat", a.repeat, "passes over all poses")->transform(integerArgument(1, 1000000))->capture_default_str();
		sub->add_flag("--shuffle", a.shuffle, "run in another order");
		sub->add_option("--pairs-out", a.pairsOut, "CSV of the intersecting pairs of leaves");
		sub->add_option("--surface", a.surfaceOut, "PLY of the contact surface: points, normals, areas and pressures");
		sub->add_flag("--json", a.json, "one JSON object per pose");
	}

	void addTune()
	{
		CLI::App* sub = add("tune", "The cheapest level, or number of spheres, that promises a force error of two bodies",
			[this] { return runTune(m_tune); });
		TuneArguments& a = m_tune;
		sub->add_option("A", a.fileA, "asset or mesh of A")->required();
		sub->add_option("B", a.fileB, "asset or mesh of B")->required();
		sub->add_option("--error", a.options.error, "force error accepted between 0.1 and 20 % overlap, 0..1")
			->required()
			->check(fraction());
		WorldSetup& w = a.options.world;
		auto* stiffness = sub->add_option("--stiffness", w.stiffness, "k of the pair [Pa/m]: also chooses precision, substeps and rate")
							  ->check(positive());
		auto* mass = sub->add_option("--mass", w.mass, "of the lighter body [kg]")->check(positive())->needs(stiffness);
		stiffness->needs(mass);
		sub->add_option("--speed", w.speed, "with which they meet [m/s]")->check(notNegative())->needs(mass)->capture_default_str();
		sub->add_option("--step", w.step, "of the world [s]")->check(positive())->needs(mass)->capture_default_str();
		sub->add_option("--distance", w.distance, "from the origin of the world [m]")
			->check(notNegative())
			->needs(mass)
			->capture_default_str();
		sub->add_option("--max-spheres", a.options.maxSpheres, "most spheres of a mesh's tree")
			->transform(integerArgument<int64_t>(1, 10000000))
			->capture_default_str();
		sub->add_flag("--json", a.json, "one JSON object");
	}

	/// Validator for finite numbers. CLI's own validators print the largest double with all 309 digits when they refuse a number.
	static CLI::Validator number(const char* range, const char* wanted, bool (*holds)(double))
	{
		return CLI::Validator(
			[wanted, holds](std::string& text) {
				double v = 0;
				return CLI::detail::lexical_cast(text, v) && std::isfinite(v) && holds(v) ? std::string()
																						  : std::string("must ") + wanted + ": " + text;
			},
			range);
	}
	static CLI::Validator unit()
	{
		return CLI::Validator(
			[](std::string& text) {
				return lengthUnit(text) ? std::string() : "must be m, cm, mm, um, in, ft, or metres as a number above 0: " + text;
			},
			"UNIT");
	}
	static CLI::Validator repairs()
	{
		return CLI::Validator(
			[](std::string& text) {
				return repairChoice(text)
					? std::string()
					: "must be auto, off, wrap, or ground with a depth in metres above 0 (--repair ground 2): " + text;
			},
			"MODE");
	}
	static CLI::Validator axes()
	{
		return CLI::Validator(
			[](std::string& text) { return upAxes(text) ? std::string() : "must be an axis like z or -x, or two like z,y: " + text; },
			"AXIS");
	}
	static CLI::Validator fraction()
	{
		return number("(0..1]", "lie above 0 and not above 1", [](double v) { return v > 0 && v <= 1; });
	}
	static CLI::Validator positive()
	{
		return number("above 0", "be a number above 0", [](double v) { return v > 0; });
	}
	static CLI::Validator notNegative()
	{
		return number("0 or more", "be a number, 0 or more", [](double v) { return v >= 0; });
	}

	CLI::App m_app{"Inner sphere trees: build, inspect, check, export, pack, query, tune", "ist"};
	std::function<int()> m_command;
	BuildArguments m_build;
	InfoArguments m_info;
	CheckArguments m_check;
	ExportArguments m_export;
	PackArguments m_pack;
	QueryArguments m_query;
	TuneArguments m_tune;
};
}  // namespace
}  // namespace ist::tools

int main(int argc, char** argv)
{
	ist::prepareCommand();
	try
	{
		return ist::tools::CommandLine().run(ist::commandArguments(argc, argv));
	}
	catch (const std::exception& e)
	{
		return ist::tools::fail(std::string("internal error: ") + e.what(), ist::tools::kInternal);
	}
}
