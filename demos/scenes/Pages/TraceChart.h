// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Pages/HtmlReport.h"

#include <functional>
#include <string>
#include <vector>

namespace scenes
{
/// A long recording, to be drawn as a line of a chart. Value number i of `count` is `value(i)` at the abscissa `x(i)`, which increases.
struct Trace
{
	size_t count = 0;
	std::function<double(size_t)> x, value;
};

/// Smallest and largest value of each of at most 400 columns, joined in their order, so that no peak is lost.
ChartSeries envelope(const std::string& name, const Trace& trace);
/// Mean of each column.
ChartSeries runningMean(const std::string& name, const Trace& trace);
/// Quantile `p` of each column.
ChartSeries runningQuantile(const std::string& name, const Trace& trace, double p);

/// Value below which the share `p` of all values lies; zero for an empty list.
double quantile(std::vector<double> values, double p);
}  // namespace scenes
