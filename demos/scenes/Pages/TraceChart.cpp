// SPDX-License-Identifier: Zlib
#include "demos/scenes/Pages/TraceChart.h"

#include <algorithm>
#include <utility>

namespace scenes
{
namespace
{
constexpr size_t kColumns = 400;

/// Calls `column(begin, end)` for each interval of the trace.
template <class Column> void eachColumn(const Trace& trace, const Column& column)
{
	const size_t columns = std::min(kColumns, trace.count);
	for (size_t c = 0; c < columns; ++c) column(c * trace.count / columns, (c + 1) * trace.count / columns);
}
}  // namespace

double quantile(std::vector<double> values, double p)
{
	if (values.empty()) return 0;
	const auto at = values.begin() +
		static_cast<std::ptrdiff_t>(std::min(values.size() - 1, static_cast<size_t>(p * static_cast<double>(values.size()))));
	std::nth_element(values.begin(), at, values.end());
	return *at;
}

ChartSeries envelope(const std::string& name, const Trace& trace)
{
	ChartSeries series{name, {}, {}, {}, false};
	eachColumn(trace, [&](size_t begin, size_t end) {
		size_t least = begin, most = begin;
		for (size_t i = begin; i < end; ++i)
		{
			if (trace.value(i) < trace.value(least)) least = i;
			if (trace.value(i) > trace.value(most)) most = i;
		}
		if (most < least) std::swap(least, most);
		for (const size_t at : {least, most})
		{
			series.x.push_back(trace.x(at));
			series.y.push_back(trace.value(at));
			if (least == most) break;
		}
	});
	return series;
}

ChartSeries runningMean(const std::string& name, const Trace& trace)
{
	ChartSeries series{name, {}, {}, {}, false};
	eachColumn(trace, [&](size_t begin, size_t end) {
		double sum = 0;
		for (size_t i = begin; i < end; ++i) sum += trace.value(i);
		series.x.push_back(trace.x((begin + end) / 2));
		series.y.push_back(sum / static_cast<double>(end - begin));
	});
	return series;
}

ChartSeries runningQuantile(const std::string& name, const Trace& trace, double p)
{
	ChartSeries series{name, {}, {}, {}, false};
	eachColumn(trace, [&](size_t begin, size_t end) {
		std::vector<double> column;
		for (size_t i = begin; i < end; ++i) column.push_back(trace.value(i));
		series.x.push_back(trace.x((begin + end) / 2));
		series.y.push_back(quantile(std::move(column), p));
	});
	return series;
}
}  // namespace scenes
