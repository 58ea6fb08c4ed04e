// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Pages/HtmlReport.h"
#include "demos/scenes/Pages/TraceChart.h"
#include "demos/scenes/Scene/SceneRun.h"

namespace scenes
{
/// Rows of names and values with units, in reading order.
std::vector<std::vector<std::string>> summaryRows(const SceneOutcome& outcome);
HtmlReport makeReport(const SceneOutcome& outcome);
std::string makeJson(const SceneOutcome& outcome);

const char* nameOf(SceneTopology topology);
/// A quantity of the ticks as a function of time.
Trace traceOf(const SceneOutcome& outcome, std::function<double(const SceneTick&)> value);
}  // namespace scenes
