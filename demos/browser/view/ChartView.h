// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Pages/HtmlReport.h"

#include <vector>

struct ImDrawList;

namespace browser
{
/// A column of charts at the right edge of a rectangle [pixels], on a pale ground. Between the Gui's `begin` and `end`. Nothing is drawn
/// where there is no room to read it.
void drawCharts(ImDrawList& to, const std::vector<scenes::Chart>& charts, double left, double top, double width, double height);
}  // namespace browser
