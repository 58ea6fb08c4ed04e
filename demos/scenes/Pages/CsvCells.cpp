// SPDX-License-Identifier: Zlib
#include "demos/scenes/Pages/CsvCells.h"

#include "demos/scenes/Pages/HtmlReport.h"

namespace scenes
{
std::string csvCells(std::initializer_list<double> values)
{
	std::string text;
	for (const double value : values) text += "," + formatNumber(value, 9);
	return text;
}

std::string csvPose(const ist::Pose& X)
{
	const ist::Quaternion q = quaternion(X.rotation);
	return csvCells({X.translation.x, X.translation.y, X.translation.z, q.x, q.y, q.z, q.w});
}

std::string csvText(const std::string& text)
{
	if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
	std::string quoted = "\"";
	for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
	return quoted + "\"";
}
}  // namespace scenes
