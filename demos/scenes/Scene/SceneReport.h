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
/// JSON with an entry for each hand in `hands`; its fields outside of that list are those of the first hand.
std::string makeJson(const SceneOutcome& outcome);

const char* nameOf(SceneTopology topology);
/// A quantity of the ticks of a hand as a function of time. `run` must outlive it.
Trace traceOf(const SceneHandRun& run, std::function<double(const SceneTick&)> value);
}  // namespace scenes
