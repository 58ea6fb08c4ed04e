// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Assembly/AssemblyRun.h"
#include "demos/scenes/Pages/HtmlReport.h"

namespace scenes
{
struct AssemblyOutcome
{
	std::vector<AssemblyCondition> conditions;
	AssemblyOptions options;

	/// True when every run was sound and the peg came into the tube at least once in every condition.
	bool ok() const;
};
ist::Result<AssemblyOutcome> runAssemblyReport(const AssemblyOptions& options);

std::vector<std::vector<std::string>> summaryRows(const AssemblyOutcome& outcome);
HtmlReport makeReport(const AssemblyOutcome& outcome);
std::string makeJson(const AssemblyOutcome& outcome);
}  // namespace scenes
