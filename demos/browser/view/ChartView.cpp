// SPDX-License-Identifier: Zlib
#include "demos/browser/view/ChartView.h"

#include "demos/scenes/Pages/ChartAxes.h"

#include <imgui.h>

#include <algorithm>

namespace browser
{
namespace
{
constexpr ImU32 kInk = IM_COL32(40, 40, 46, 255), kGrid = IM_COL32(0, 0, 0, 28), kPaper = IM_COL32(255, 255, 255, 215);

struct Rectangle
{
	float left, top, right, bottom;
};

ImU32 colourOf(const scenes::Chart& chart, size_t i)
{
	const int like = chart.series[i].like;
	const unsigned c = scenes::seriesColour(like < 0 ? i : size_t(like));
	return IM_COL32(c >> 16 & 255, c >> 8 & 255, c & 255, 255);
}

/// Draws a grid whose ticks are as far apart as their labels need.
void drawGrid(ImDrawList& to, const scenes::ChartAxes& axes, const Rectangle& r)
{
	const float line = ImGui::GetTextLineHeight();
	float free = -1e9f;
	for (const double v : axes.x.ticks())
	{
		const float x = float(axes.x(v));
		const std::string text = scenes::formatNumber(v);
		const float wide = ImGui::CalcTextSize(text.c_str()).x;
		to.AddLine({x, r.top}, {x, r.bottom}, kGrid);
		if (x - 0.5f * wide < free) continue;
		to.AddText({x - 0.5f * wide, r.bottom}, kInk, text.c_str());
		free = x + 0.5f * wide + 0.4f * line;
	}
	free = 1e9f;
	for (const double v : axes.y.ticks())
	{
		const float y = float(axes.y(v));
		const std::string text = scenes::formatNumber(v);
		to.AddLine({r.left, y}, {r.right, y}, kGrid);
		if (y + 0.5f * line > free) continue;
		to.AddText({r.left - ImGui::CalcTextSize(text.c_str()).x - 0.3f * line, y - 0.5f * line}, kInk, text.c_str());
		free = y - 0.5f * line;
	}
	to.AddRect({r.left, r.top}, {r.right, r.bottom}, kGrid);
}

void drawSeries(ImDrawList& to, const scenes::Chart& chart, size_t i, const scenes::ChartAxes& axes)
{
	const scenes::ChartSeries& series = chart.series[i];
	const float line = ImGui::GetTextLineHeight();
	std::vector<ImVec2> points;
	const auto endLine = [&] {
		to.AddPolyline(points.data(), int(points.size()), colourOf(chart, i), 0, 0.13f * line);
		points.clear();
	};
	for (size_t k = 0; k < scenes::pointCount(series); ++k)
	{
		const scenes::ChartPoint p = scenes::pointOf(series, k);
		if (!scenes::isShown(p, chart.logarithmic))
		{
			endLine();
			continue;
		}
		const ImVec2 at{float(axes.x(p.x)), float(axes.y(p.y))};
		if (series.markers) to.AddCircleFilled(at, 0.32f * line, colourOf(chart, i));
		else points.push_back(at);
	}
	endLine();
}

void drawChart(ImDrawList& to, const scenes::Chart& chart, const Rectangle& r)
{
	const float line = ImGui::GetTextLineHeight(), pad = 0.4f * line;
	to.AddRectFilled({r.left, r.top}, {r.right, r.bottom}, kPaper, pad);
	float x = r.left + pad;
	const float y = r.top + 0.5f * pad;
	for (size_t i = 0; i < chart.series.size(); ++i)
	{
		if (chart.series[i].like >= 0) continue;
		const std::string& name = chart.series[i].name;
		to.AddText({x, y}, colourOf(chart, i), name.c_str());
		x += ImGui::CalcTextSize(name.c_str()).x + line;
	}
	const Rectangle inner{r.left + 3 * line, r.top + 1.7f * line, r.right - line, r.bottom - 2.4f * line};
	scenes::ChartAxes axes = scenes::fitAxes(chart);
	axes.x.from = double(inner.left), axes.x.to = double(inner.right);
	axes.y.from = double(inner.bottom), axes.y.to = double(inner.top);
	drawGrid(to, axes, inner);
	for (size_t i = 0; i < chart.series.size(); ++i) drawSeries(to, chart, i, axes);
	to.AddText({inner.left + pad, inner.top}, kInk, chart.yLabel.c_str());
	const float wide = ImGui::CalcTextSize(chart.xLabel.c_str()).x;
	to.AddText({0.5f * (inner.left + inner.right - wide), inner.bottom + 1.1f * line}, kInk, chart.xLabel.c_str());
}
}  // namespace

void drawCharts(ImDrawList& to, const std::vector<scenes::Chart>& charts, double left, double top, double width, double height)
{
	if (charts.empty()) return;
	const float line = ImGui::GetTextLineHeight(), gap = 0.5f * line;
	const float wide = std::min(25 * line, 0.5f * float(width)),
				high = std::min(14 * line, (float(height) - gap) / float(charts.size()) - gap);
	if (wide < 12 * line || high < 7 * line) return;
	Rectangle r{float(left + width) - gap - wide, float(top) + gap, float(left + width) - gap, float(top) + gap + high};
	for (const scenes::Chart& chart : charts)
	{
		drawChart(to, chart, r);
		r.top += high + gap;
		r.bottom += high + gap;
	}
}
}  // namespace browser
