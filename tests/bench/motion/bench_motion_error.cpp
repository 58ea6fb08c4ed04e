// SPDX-License-Identifier: Zlib
// Measures the error of the motion over what it costs: scenes in fixed steps of 1/30 s to 0.1 ms, at three levels of accuracy, with
// materials given and with nothing set, and in stock Bullet. Truth is the same scene at a small part of the step, and a closed form where
// there is one. Runs are kept in a folder, so that a sweep can be interrupted. The program in double precision makes the truth and comes
// first:
//     bench_motion_error-float64 && bench_motion_error --report accuracy-of-motion.html
// Usage: bench_motion_error [--scene NAME]... [--quick] [--runs FOLDER=motion-runs] [--judge-only] [--report FILE.html]
#include "tests/bench/motion/MotionPage.h"

#include <cstdio>
#include <string>

using namespace bench;

namespace
{
struct Options
{
	std::vector<std::string> scenes;
	std::string runs = "motion-runs", report;
	bool isQuick = false, judgesOnly = false;

	bool wants(const std::string& name) const
	{
		for (const std::string& scene : scenes)
			if (scene == name) return true;
		return scenes.empty();
	}
};

/// Nothing where an option is not known or lacks its value, or a scene does not exist.
std::optional<Options> parse(int argc, char** argv)
{
	Options o;
	for (int i = 1; i < argc; ++i)
	{
		const std::string key = argv[i];
		if (key == "--quick") o.isQuick = true;
		else if (key == "--judge-only") o.judgesOnly = true;
		else if (i + 1 >= argc) return std::printf("what is %s? See the first lines of bench_motion_error.cpp\n", argv[i]), std::nullopt;
		else if (key == "--scene") o.scenes.push_back(argv[++i]);
		else if (key == "--runs") o.runs = argv[++i];
		else if (key == "--report") o.report = argv[++i];
		else return std::printf("what is %s? See the first lines of bench_motion_error.cpp\n", argv[i]), std::nullopt;
	}
	for (const std::string& name : o.scenes)
	{
		bool isKnown = false;
		for (const MotionEntry& entry : motionScenes()) isKnown |= name == entry.name;
		if (!isKnown) return std::printf("there is no scene %s\n", name.c_str()), std::nullopt;
	}
	return o;
}
}  // namespace

int main(int argc, char** argv)
{
	const std::optional<Options> options = parse(argc, argv);
	if (!options) return 2;
	MotionRecords records(options->runs);
	std::vector<MotionFindings> all;
	bool isWhole = true;
	for (MotionEntry entry : motionScenes())
	{
		if (!options->wants(entry.name)) continue;
		if (options->isQuick) entry = quick(entry);
		const auto failed = options->judgesOnly ? std::nullopt : recordRuns(records, entry);
		ist::Result<MotionFindings> found = failed ? ist::Result<MotionFindings>(*failed) : judgeRuns(records, entry);
		if (!found)
		{
			std::printf("%s\n", found.error().message.c_str());
			isWhole = false;
			continue;
		}
		print(found.value());
		all.push_back(std::move(found).value());
	}
	if (all.empty()) return 1;
	printGains(all);
	if (options->report.empty() || makePage(all).write(options->report)) return isWhole ? 0 : 1;
	std::printf("cannot write %s\n", options->report.c_str());
	return 1;
}
