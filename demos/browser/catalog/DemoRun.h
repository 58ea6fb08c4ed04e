// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/BrowsableDemo.h"

namespace browser
{
struct DemoRunOptions
{
	long long frames = -1;  ///< number of steps; negative: as many as the demo's duration needs
	double dt = 0;          ///< step [s]; 0: the demo's own step
	/// Called before the first step and after each, with the number of steps done. Return false to end the run.
	std::function<bool(long long)> afterStep;
};

struct DemoOutcome
{
	std::string name, about;
	std::vector<Figure> figures;
	std::vector<Curve> curves;
	std::vector<scenes::Chart> charts;
	std::vector<std::string> report;  ///< rows that name the model for each pair, at the end
	std::string reportJson;
	long long frames = 0;
	double dt = 0, seconds = 0;   ///< step, and simulated time [s]
	double stepMicroseconds = 0;  ///< mean time of a step on this machine [us]
	bool complete = false;        ///< true: the run was as long as the demo's duration; only then are the figures judged

	bool ok() const;
};

/// Steps a prepared demo from its start.
ist::Result<DemoOutcome> runDemo(BrowsableDemo& demo, const std::string& name, const std::string& about, const DemoRunOptions& options);

std::string makeJson(const DemoOutcome& outcome);
std::vector<std::vector<std::string>> summaryRows(const DemoOutcome& outcome);
scenes::HtmlReport makeReport(const DemoOutcome& outcome);
}  // namespace browser
