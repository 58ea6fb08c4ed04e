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
	std::vector<double> sigma;  ///< half length of the error bars; empty: none
	bool markers = false;       ///< points instead of a line
	int like = -1;              ///< points in the colour of this series, without a name of their own
};

struct Chart
{
	std::string title;
	std::string xLabel, yLabel;  ///< with the unit, "depth [mm]"
	std::vector<ChartSeries> series;
	bool logarithmic = false;  ///< both axes; values must be above zero
};

/// The chart as a picture of its own.
std::string chartSvg(const Chart& chart);

/// A page with text, tables and line charts in one file: inline style and SVG, no scripts, nothing loaded from elsewhere.
class HtmlReport
{
public:
	explicit HtmlReport(std::string title);

	void heading(const std::string& text);
	void paragraph(const std::string& text);
	/// The first column is set as text, the others as numbers.
	void table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows);
	/// Values that are not finite, or not above zero on logarithmic axes, are left out.
	void chart(const Chart& chart);

	std::string text() const;
	/// False when the file cannot be written: then nothing is left of it.
	bool write(const std::string& path) const;

private:
	std::string m_title, m_body;
};

/// `value` with the given number of significant digits, without needless zeros and, below a million, without an exponent: 2070 rather
/// than 2.07e+03. With a point, whatever the locale of the program, as files need it.
std::string formatNumber(double value, int digits = 4);
/// With so many decimals, and a point.
std::string formatFixed(double value, int decimals);
}  // namespace scenes
