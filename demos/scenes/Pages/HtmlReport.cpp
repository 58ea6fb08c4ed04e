// SPDX-License-Identifier: Zlib
#include "demos/scenes/Pages/HtmlReport.h"

#include "demos/scenes/Pages/ChartAxes.h"
#include "demos/scenes/Pages/TextFile.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <utility>

namespace scenes
{
namespace
{
constexpr const char* kStyle =
	"body{font:16px/1.55 system-ui,-apple-system,'Segoe UI',Roboto,Helvetica,Arial,sans-serif;color:#222;background:#fafaf8;"
	"margin:0 auto;max-width:60rem;padding:2rem 1.25rem}"
	"h1{font-size:1.8rem;line-height:1.2;margin:0 0 1rem}h2{font-size:1.25rem;margin:2.2rem 0 .6rem}"
	"p{max-width:46rem;margin:.6rem 0}"
	"table{display:block;overflow-x:auto;border-collapse:collapse;margin:1rem 0;background:#fff;font-variant-numeric:tabular-nums}"
	"th,td{padding:.4rem .9rem;border-bottom:1px solid #e4e4e0;text-align:right}"
	"th:first-child,td:first-child{text-align:left}th{background:#f0f0ec;font-weight:600}"
	"figure{margin:1.2rem 0;background:#fff;border:1px solid #e4e4e0;border-radius:6px;padding:1rem}"
	"figcaption{font-weight:600;margin-bottom:.4rem}svg{display:block;width:100%;height:auto}"
	"svg text{font:13px system-ui,-apple-system,'Segoe UI',Roboto,Helvetica,Arial,sans-serif;fill:#333}";

std::string escaped(const std::string& text)
{
	std::string out;
	for (const char c : text)
	{
		if (c == '&') out += "&amp;";
		else if (c == '<') out += "&lt;";
		else if (c == '>') out += "&gt;";
		else if (c == '"') out += "&quot;";
		else out += c;
	}
	return out;
}

/// SVG coordinate; a tenth of a pixel is precise enough.
std::string pixel(double value) { return formatFixed(value, 1); }

struct Frame : ChartAxes
{
	static constexpr double kWidth = 860, kHeight = 340, kLeft = 84, kRight = 20, kTop = 38, kBottom = 52;
	bool logarithmic = false;
};

Frame fitFrame(const Chart& chart)
{
	Frame frame{fitAxes(chart), chart.logarithmic};
	frame.x.from = Frame::kLeft;
	frame.x.to = Frame::kWidth - Frame::kRight;
	frame.y.from = Frame::kHeight - Frame::kBottom;
	frame.y.to = Frame::kTop;
	return frame;
}

std::string colourOf(size_t i)
{
	char text[8];
	std::snprintf(text, sizeof text, "#%06X", seriesColour(i));
	return text;
}

std::string lineTag(double x1, double y1, double x2, double y2, const std::string& stroke)
{
	return "<line x1=\"" + pixel(x1) + "\" y1=\"" + pixel(y1) + "\" x2=\"" + pixel(x2) + "\" y2=\"" + pixel(y2) + "\" stroke=\"" + stroke +
		"\"/>";
}

std::string textTag(double x, double y, const std::string& anchor, const std::string& text, const std::string& more = "")
{
	return "<text x=\"" + pixel(x) + "\" y=\"" + pixel(y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" + escaped(text) + "</text>";
}

std::string drawGrid(const Frame& frame, const Chart& chart)
{
	const double left = Frame::kLeft, right = frame.x.to, top = Frame::kTop, bottom = frame.y.from;
	std::string out;
	for (const double v : frame.x.ticks())
	{
		out += lineTag(frame.x(v), top, frame.x(v), bottom, "#e8e8e4");
		out += textTag(frame.x(v), bottom + 19, "middle", formatNumber(v));
	}
	for (const double v : frame.y.ticks())
	{
		out += lineTag(left, frame.y(v), right, frame.y(v), frame.y.isZero(v) ? "#a8a8a4" : "#e8e8e4");
		out += textTag(left - 8, frame.y(v) + 4.5, "end", formatNumber(v));
	}
	out += lineTag(left, bottom, right, bottom, "#777") + lineTag(left, top, left, bottom, "#777");
	out += textTag((left + right) / 2, Frame::kHeight - 10, "middle", chart.xLabel);
	const double middle = (top + bottom) / 2;
	out += textTag(18, middle, "middle", chart.yLabel, " transform=\"rotate(-90 18 " + pixel(middle) + ")\"");
	return out;
}

std::string drawMarkers(const Frame& frame, const ChartSeries& series, const std::string& color, double shift)
{
	std::string out;
	for (size_t i = 0; i < pointCount(series); ++i)
	{
		const ChartPoint p = pointOf(series, i);
		if (!isShown(p, frame.logarithmic)) continue;
		const double x = frame.x(p.x) + shift;
		if (p.sigma > 0)
		{
			const double low = frame.y(p.y - p.sigma), high = frame.y(p.y + p.sigma);
			out += lineTag(x, low, x, high, color) + lineTag(x - 3, low, x + 3, low, color) + lineTag(x - 3, high, x + 3, high, color);
		}
		out += "<circle cx=\"" + pixel(x) + "\" cy=\"" + pixel(frame.y(p.y)) + "\" r=\"3.5\" fill=\"" + color + "\"/>";
	}
	return out;
}

std::string drawLine(const Frame& frame, const ChartSeries& series, const std::string& color)
{
	std::string path;
	bool pen = false;
	for (size_t i = 0; i < pointCount(series); ++i)
	{
		const ChartPoint p = pointOf(series, i);
		const bool shown = isShown(p, frame.logarithmic);
		if (shown) path += (pen ? "L" : "M") + pixel(frame.x(p.x)) + " " + pixel(frame.y(p.y));
		pen = shown;
	}
	return "<path d=\"" + path + "\" fill=\"none\" stroke=\"" + color + "\" stroke-width=\"2\" stroke-linejoin=\"round\"/>";
}

std::string drawLegend(const Chart& chart)
{
	std::string out;
	double x = Frame::kLeft + 4, y = 12;
	for (size_t i = 0; i < chart.series.size(); ++i)
	{
		if (chart.series[i].like >= 0) continue;
		const double width = 24 + 7.2 * static_cast<double>(chart.series[i].name.size());
		if (i > 0 && x + width > Frame::kWidth - Frame::kRight) x = Frame::kLeft + 4, y += 16;
		const std::string color = colourOf(i);
		out += "<rect x=\"" + pixel(x) + "\" y=\"" + pixel(y) + "\" width=\"18\" height=\"5\" rx=\"2\" fill=\"" + color + "\"/>";
		out += textTag(x + 24, y + 7, "start", chart.series[i].name);
		x += width + 24;
	}
	return out;
}
}  // namespace

std::string formatNumber(double value, int digits)
{
	if (std::fabs(value) < 1e-300) return "0";
	char buffer[40];
	char* const end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, digits).ptr;
	if (std::fabs(value) < 1 || std::fabs(value) >= 1e6 || std::find(buffer, end, 'e') == end) return std::string(buffer, end);
	double rounded = value;
	std::from_chars(buffer, end, rounded);
	return formatFixed(rounded, 0);
}

std::string formatFixed(double value, int decimals)
{
	char buffer[400];
	return std::string(buffer, std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals).ptr);
}

HtmlReport::HtmlReport(std::string title) : m_title(std::move(title)) {}

void HtmlReport::heading(const std::string& text) { m_body += "<h2>" + escaped(text) + "</h2>\n"; }
void HtmlReport::paragraph(const std::string& text) { m_body += "<p>" + escaped(text) + "</p>\n"; }

void HtmlReport::table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows)
{
	m_body += "<table><thead><tr>";
	for (const std::string& cell : head) m_body += "<th>" + escaped(cell) + "</th>";
	m_body += "</tr></thead><tbody>\n";
	for (const auto& row : rows)
	{
		m_body += "<tr>";
		for (const std::string& cell : row) m_body += "<td>" + escaped(cell) + "</td>";
		m_body += "</tr>\n";
	}
	m_body += "</tbody></table>\n";
}

void HtmlReport::chart(const Chart& chart)
{
	m_body += "<figure><figcaption>" + escaped(chart.title) + "</figcaption>" + chartSvg(chart) + "</figure>\n";
}

std::string chartSvg(const Chart& chart)
{
	const Frame frame = fitFrame(chart);
	std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + pixel(Frame::kWidth) + " " + pixel(Frame::kHeight) +
		"\" role=\"img\" aria-label=\"" + escaped(chart.title) +
		"\" font-family=\"sans-serif\" font-size=\"13\" fill=\"#333\" style=\"background:#fff\">\n";
	out += drawGrid(frame, chart);
	const auto isBeside = [](const ChartSeries& series) { return series.markers && !series.sigma.empty() && series.like < 0; };
	const auto marked = std::count_if(chart.series.begin(), chart.series.end(), isBeside);
	// Series with error bars are shifted sideways, so that bars at the same abscissa stay apart.
	double shift = -2.5 * static_cast<double>(marked + 1);
	for (size_t i = 0; i < chart.series.size(); ++i)
	{
		const ChartSeries& series = chart.series[i];
		const std::string colour = colourOf(series.like < 0 ? i : size_t(series.like));
		if (isBeside(series)) shift += 5;
		out += series.markers ? drawMarkers(frame, series, colour, isBeside(series) ? shift : 0) : drawLine(frame, series, colour);
	}
	return out + drawLegend(chart) + "</svg>";
}

std::string HtmlReport::text() const
{
	return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width,"
		   "initial-scale=1\"><title>" +
		escaped(m_title) + "</title><style>" + kStyle + "</style></head>\n<body><h1>" + escaped(m_title) + "</h1>\n" + m_body +
		"</body></html>\n";
}

bool HtmlReport::write(const std::string& path) const { return writeTextFile(path, text()); }
}  // namespace scenes
