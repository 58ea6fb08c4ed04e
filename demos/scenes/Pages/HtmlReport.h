// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

namespace scenes
{
struct ChartSeries
{
	std::string name;
	std::vector<double> x, y;
	std::vector<double> sigma;  ///< half lengths of the error bars; empty: none
	bool markers = false;       ///< true: points instead of a line
	int like = -1;              ///< index of the series whose colour these points have, without a name of their own; -1: own colour
};

struct Chart
{
	std::string title;
	std::string xLabel, yLabel;  ///< labels with the unit, such as "depth [mm]"
	std::vector<ChartSeries> series;
	bool logarithmic = false;  ///< true: both axes are logarithmic; values must be above zero
};

/// The chart as a separate picture.
std::string chartSvg(const Chart& chart);

/// A page with text, tables and line charts in one file. Style and SVG are inline; the page has no scripts and loads nothing.
class HtmlReport
{
public:
	explicit HtmlReport(std::string title);

	void heading(const std::string& text);
	void paragraph(const std::string& text);
	/// Adds a table. The first column is set as text, the others as numbers.
	void table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows);
	/// Adds a chart. Values that are not finite, or not above zero on logarithmic axes, are left out.
	void chart(const Chart& chart);

	std::string text() const;
	/// Returns false when the file cannot be written; it then leaves no file.
	bool write(const std::string& path) const;

private:
	std::string m_title, m_body;
};

/// Formats `value` with the given number of significant digits, without trailing zeros. Below a million it uses no exponent: 2070 rather
/// than 2.07e+03. The decimal separator is a point in every locale, as files need it.
std::string formatNumber(double value, int digits = 4);
/// Formats `value` with so many decimals, and a decimal point in every locale.
std::string formatFixed(double value, int decimals);
}  // namespace scenes
