// SPDX-License-Identifier: Zlib
// Compares speed and accuracy against quadrature on the triangles: bodies, spheres, and level, budget or tolerance, at several
// overlaps. Beside them are the paper's own estimator, closed forms and other libraries, in single poses and on paths. Writes
// pareto.csv, pareto.json, pareto.html, and a front as SVG for each pair.
// Usage: bench_pareto [--quick | --tiny] [--out FOLDER=.] [--keep FOLDER] [--pairs A-B,C-D...] [--spheres N,M...] [--passes N] [--paths
// N] [--peers 0|1]
// The full run takes half an hour of two processors, --quick takes three minutes, --tiny a few seconds. --keep keeps trees and
// references in this folder from run to run. Intermediate results are written when a pair is done with a number of spheres.
#include "demos/scenes/Pages/TextFile.h"
#include "tests/bench/peers/ParetoPage.h"

#include <charconv>
#include <cstdio>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>

using namespace bench;

namespace
{
SweepSettings allOfIt()
{
	SweepSettings s;
	s.pairs = {{"bunny", "bunny"}, {"torus", "bunny"}, {"jack", "torus"}, {"bunny", "box"}, {"jack", "ball"}, {"knot", "bunny"},
		{"crown", "ball"}, {"sword", "torus"}, {"plate", "knot"}, {"rod", "box"}, {"crown", "bunny"}, {"rod", "jack"}};
	s.spheres = {100, 300, 1000, 3000, 10000, 30000, 100000};
	s.manySpheres = {1000000};
	s.truth = {{0.001, 0.003, 0.01, 0.03, 0.1, 0.2}, 12, 100, 30000, 23};
	s.passes = 10;
	s.paths = 1;
	return s;
}

SweepSettings quick()
{
	SweepSettings s = allOfIt();
	s.pairs = {{"bunny", "bunny"}, {"jack", "ball"}, {"rod", "jack"}};
	s.spheres = {300, 1000, 3000};
	s.manySpheres = {};
	s.truth = {{0.001, 0.01, 0.1}, 8, 60, 10000, 23};
	s.passes = 5;
	s.paths = 2;
	return s;
}

SweepSettings tiny()
{
	SweepSettings s = quick();
	s.pairs = {{"box", "ball"}};
	s.spheres = {100, 400};
	s.truth = {{0.01, 0.1}, 3, 40, 3000, 23};
	s.passes = 2;
	s.paths = 1;
	return s;
}

std::vector<std::string> split(const std::string& text, char at)
{
	std::vector<std::string> parts;
	std::istringstream stream(text);
	for (std::string part; std::getline(stream, part, at);) parts.push_back(part);
	return parts;
}

/// Returns false if the text is not entirely a number, or if the number is too small.
bool takeNumber(const std::string& text, int least, int& into)
{
	const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), into);
	return error == std::errc() && end == text.data() + text.size() && into >= least;
}

/// Returns false if the argument is unknown.
bool takeOption(SweepSettings& settings, std::string& folder, const std::string& name, const std::string& value)
{
	if (name == "--out") return folder = value, true;
	if (name == "--keep") return settings.folder = value, true;
	if (name == "--passes") return takeNumber(value, 1, settings.passes);
	if (name == "--paths") return takeNumber(value, 0, settings.paths);
	if (name == "--peers") return value == "0" || value == "1" ? settings.peers = value == "1", true : false;
	if (name == "--spheres")
	{
		settings.spheres.clear();
		settings.manySpheres.clear();
		for (const std::string& number : split(value, ','))
			if (!takeNumber(number, 1, settings.spheres.emplace_back())) return false;
		return !settings.spheres.empty();
	}
	if (name != "--pairs") return false;
	settings.pairs.clear();
	for (const std::string& pair : split(value, ','))
	{
		const std::vector<std::string> names = split(pair, '-');
		if (names.size() != 2) return false;
		settings.pairs.push_back({names[0], names[1]});
	}
	return !settings.pairs.empty();
}

bool writeAll(const Sweep& sweep, const std::string& folder)
{
	bool good = scenes::writeTextFile(folder + "/pareto.csv", paretoCsv(sweep)) &&
		scenes::writeTextFile(folder + "/pareto.json", paretoJson(sweep)) &&
		scenes::writeTextFile(folder + "/pareto.html", paretoHtml(sweep));
	std::set<std::string> pairs;
	for (const ParetoRow& row : sweep.rows) pairs.insert(row.pair);
	for (const std::string& pair : pairs) good = good && scenes::writeTextFile(folder + "/front-" + pair + ".svg", frontSvg(sweep, pair));
	return good;
}
}  // namespace

int main(int argc, char** argv)
{
	SweepSettings settings = allOfIt();
	std::string folder = ".";
	int i = 1;
	if (argc > 1 && (argv[1] == std::string("--quick") || argv[1] == std::string("--tiny")))
		settings = argv[i++] == std::string("--quick") ? quick() : tiny();
	for (; i < argc; i += 2)
		if (i + 1 == argc || !takeOption(settings, folder, argv[i], argv[i + 1]))
			return std::fprintf(stderr,
					   "usage: bench_pareto [--quick | --tiny] [--out FOLDER] [--keep FOLDER] [--pairs A-B,C-D...] [--spheres N,M...] "
					   "[--passes N] [--paths N] "
					   "[--peers 0|1]\n"),
				   2;
	std::error_code error;
	for (const std::string& wanted : {folder, settings.folder})
		if (!wanted.empty()) std::filesystem::create_directories(wanted, error);
	Sweep sweep;
	if (!runSweep(settings, sweep, [&] { return writeAll(sweep, folder); }))
		return std::fprintf(stderr, "bench_pareto: cannot write to %s\n", folder.c_str()), 1;
	for (const ErrorBoundRow& p : sweep.errorBounds)
		std::printf(
			"%-14s %6d spheres, accepted %4.1f %%: held in %5.1f %% of %d poses, kept in %5.1f %%, true error %.2f of the promise in the "
			"median, "
			"%.0f %% of the force where %.0f %% was promised at worst, cost %.2f of the leaves', %.2f of the cheapest fixed level's\n",
			p.pair.c_str(), p.spheres, 100 * p.error, 100 * p.held, p.poses, 100 * p.kept, p.ofErrorBound, 100 * p.worst,
			100 * p.largestErrorBound, p.ofLeaves, p.ofFixed);
	return 0;
}
