// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Pages/HtmlReport.h"

namespace scenes
{
/// An axis that maps values to places on a picture, with ticks at round numbers (1, 2 or 5 times a power of ten). A logarithmic axis
/// stores the logarithms of its ends.
struct ChartAxis
{
	double lower = 0, upper = 1, step = 0.2;
	double from = 0, to = 1;  ///< places of the ends
	bool logarithmic = false;

	double operator()(double value) const;
	void fit(double least, double most, bool grow);
	void fitLogarithms(double least, double most);
	std::vector<double> ticks() const;
	/// True when a tick is the axis' zero.
	bool isZero(double tick) const;
};

struct ChartPoint
{
	double x, y, sigma;
};
size_t pointCount(const ChartSeries& series);
ChartPoint pointOf(const ChartSeries& series, size_t i);
/// True when the point is finite and, on logarithmic axes, above zero.
bool isShown(const ChartPoint& point, bool logarithmic);

/// Axes that contain all points of a chart. Their places are set later.
struct ChartAxes
{
	ChartAxis x, y;
};
ChartAxes fitAxes(const Chart& chart);

/// Colour of a series as 0xRRGGBB; the list repeats. The colours are those of Okabe and Ito, with a brown instead of their yellow, which
/// is too pale for thin lines.
unsigned seriesColour(size_t i);
}  // namespace scenes
