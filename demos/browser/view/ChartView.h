// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Pages/HtmlReport.h"

#include <vector>

struct ImDrawList;

namespace browser
{
/// Draws a column of charts at the right edge of a rectangle [pixels], on a pale background. Call it between `begin` and `end` of the
/// Gui. Charts that would be too small to read are not drawn.
void drawCharts(ImDrawList& to, const std::vector<scenes::Chart>& charts, double left, double top, double width, double height);
}  // namespace browser
