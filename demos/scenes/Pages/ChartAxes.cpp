// SPDX-License-Identifier: Zlib
#include "demos/scenes/Pages/ChartAxes.h"

#include <algorithm>
#include <cmath>

namespace scenes
{
double ChartAxis::operator()(double value) const
{
	return from + ((logarithmic ? std::log10(value) : value) - lower) / (upper - lower) * (to - from);
}

bool ChartAxis::isZero(double tick) const { return std::fabs(tick) < 1e-9 * step; }

void ChartAxis::fitLogarithms(double least, double most)
{
	logarithmic = true;
	lower = least <= most ? std::log10(least) - 0.05 : 0;
	upper = least <= most ? std::log10(most) + 0.05 : 1;
}

void ChartAxis::fit(double least, double most, bool grow)
{
	if (!(least <= most)) least = 0, most = 1;
	if (most - least <= 1e-12 * std::max(std::fabs(least), std::fabs(most)))
	{
		const double pad = most != 0 ? 0.1 * std::fabs(most) : 1;
		least -= pad;
		most += pad;
	}
	const double raw = (most - least) / 6;
	const double power = std::pow(10.0, std::floor(std::log10(raw)));
	const double digit = raw / power;
	step = power * (digit <= 1 ? 1 : digit <= 2 ? 2 : digit <= 5 ? 5 : 10);
	lower = grow ? step * std::floor(least / step + 1e-9) : least;
	upper = grow ? step * std::ceil(most / step - 1e-9) : most;
}

std::vector<double> ChartAxis::ticks() const
{
	std::vector<double> values;
	for (int power = int(std::floor(lower)); logarithmic && power <= upper; ++power)
		for (const double digit : {1, 2, 5})
			if (const double at = power + std::log10(digit); at >= lower && at <= upper && (digit == 1 || upper - lower < 3))
				values.push_back(std::pow(10.0, at));
	if (logarithmic) return values;
	const double first = std::ceil(lower / step - 1e-9);
	for (int i = 0; (first + i) * step <= upper + 1e-9 * step; ++i) values.push_back((first + i) * step);
	return values;
}

size_t pointCount(const ChartSeries& series) { return std::min(series.x.size(), series.y.size()); }

ChartPoint pointOf(const ChartSeries& series, size_t i)
{
	return {series.x[i], series.y[i], i < series.sigma.size() ? series.sigma[i] : 0.0};
}

bool isShown(const ChartPoint& p, bool logarithmic)
{
	return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.sigma) && (!logarithmic || (p.x > 0 && p.y > 0));
}

ChartAxes fitAxes(const Chart& chart)
{
	double xLeast = 1e300, xMost = -1e300, yLeast = 1e300, yMost = -1e300;
	for (const ChartSeries& series : chart.series)
		for (size_t i = 0; i < pointCount(series); ++i)
		{
			const ChartPoint p = pointOf(series, i);
			if (!isShown(p, chart.logarithmic)) continue;
			xLeast = std::min(xLeast, p.x);
			xMost = std::max(xMost, p.x);
			yLeast = std::min(yLeast, p.y - p.sigma);
			yMost = std::max(yMost, p.y + p.sigma);
		}
	ChartAxes axes;
	if (chart.logarithmic)
	{
		axes.x.fitLogarithms(xLeast, xMost);
		axes.y.fitLogarithms(yLeast, yMost);
	}
	else
	{
		axes.x.fit(xLeast, xMost, false);
		axes.y.fit(yLeast, yMost, true);
	}
	return axes;
}

unsigned seriesColour(size_t i)
{
	constexpr unsigned kColours[] = {0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0xE69F00, 0x56B4E9, 0x000000, 0xA6761D};
	return kColours[i % std::size(kColours)];
}
}  // namespace scenes
