// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/DemoArguments.h"

#include <cstdio>

namespace scenes
{
/// Progress of long work on stderr, as the `ist` command shows it: a bar on a terminal, a line for each tenth elsewhere. Always goes on.
bool showProgress(const char* stage, double fraction);
/// Call before something else is written to stderr: ends the line of an unfinished bar.
void endProgress();
/// A message for people.
void say(const std::string& text);

/// Prints what a demo found, in the form that was asked for.
template <class Outcome> void printOutcome(const DemoArguments& a, const Outcome& outcome)
{
	endProgress();
	if (a.json) std::printf("%s\n", makeJson(outcome).c_str());
	else
		for (const auto& row : summaryRows(outcome))
			row[1].empty() ? std::puts(row[0].c_str()) : std::printf("%-44s %12s %s\n", row[0].c_str(), row[1].c_str(), row[2].c_str());
}

/// Prints what a demo found, and writes its report. Returns the exit code.
template <class Outcome> int present(const DemoArguments& a, const Outcome& outcome)
{
	printOutcome(a, outcome);
	if (a.report.empty()) return 0;
	if (!makeReport(outcome).write(a.report))
	{
		std::fprintf(stderr, "haptic_demos: cannot write the report to %s\n", a.report.c_str());
		return 1;
	}
	std::fprintf(stderr, "report: %s\n", a.report.c_str());
	return 0;
}

}  // namespace scenes
