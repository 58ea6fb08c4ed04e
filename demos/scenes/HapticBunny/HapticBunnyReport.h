// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/HapticBunny/HapticBunny.h"
#include "demos/scenes/Pages/HtmlReport.h"

namespace scenes
{
/// Rows of names and values with units, in reading order.
std::vector<std::vector<std::string>> summaryRows(const HapticBunnyOutcome& outcome);
HtmlReport makeReport(const HapticBunnyOutcome& outcome);
std::string makeJson(const HapticBunnyOutcome& outcome);
}  // namespace scenes
