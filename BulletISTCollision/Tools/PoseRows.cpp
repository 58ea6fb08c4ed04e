// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/PoseRows.h"

#include "BulletISTCollision/Core/Platform/Utf8Path.h"
#include "BulletISTCollision/Tools/NumberText.h"

#include <algorithm>
#include <array>
#include <fstream>

namespace ist::tools
{
namespace
{
constexpr std::array<const char*, 7> kNames = {"tx", "ty", "tz", "qx", "qy", "qz", "qw"};
using Fields = std::array<std::string_view, 7>;

std::vector<std::string_view> splitCommas(std::string_view line)
{
	std::vector<std::string_view> cells;
	for (size_t begin = 0;;)
	{
		const size_t comma = line.find(',', begin);
		cells.push_back(trimmed(line.substr(begin, comma == std::string_view::npos ? comma : comma - begin)));
		if (comma == std::string_view::npos) return cells;
		begin = comma + 1;
	}
}

PoseRow rowOf(const Fields& fields)
{
	double v[7];
	PoseRow row;
	for (size_t i = 0; i < fields.size(); ++i)
		if (!parseNumber(fields[i], v[i]) || !std::isfinite(v[i]))
		{
			row.error = std::string(kNames[i]) + " is not a finite number: \"" + std::string(fields[i]) + "\"";
			return row;
		}
	const double n = std::sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6]);
	if (!(std::fabs(n - 1) <= 1e-3))
	{
		row.error = "the quaternion has length " + numberText(n) + "; it must be within 0.001 of 1";
		return row;
	}
	row.pose = {rotationMatrix({v[3] / n, v[4] / n, v[5] / n, v[6] / n}), {v[0], v[1], v[2]}};
	return row;
}

Result<std::array<size_t, 7>> findColumns(const std::string& path, std::string_view header)
{
	if (header.starts_with("\xef\xbb\xbf")) header.remove_prefix(3);
	const std::vector<std::string_view> names = splitCommas(header);
	std::array<size_t, 7> columns{};
	for (size_t i = 0; i < kNames.size(); ++i)
	{
		const auto found = std::find(names.begin(), names.end(), kNames[i]);
		if (found == names.end())
			return Error{"\"" + path + "\" has no column " + kNames[i] + "; its first line must name tx,ty,tz,qx,qy,qz,qw"};
		columns[i] = static_cast<size_t>(found - names.begin());
	}
	return columns;
}
}  // namespace

PoseRow parsePose(const std::string& text)
{
	const std::vector<std::string_view> cells = splitCommas(text);
	PoseRow row;
	if (cells.size() != kNames.size())
	{
		row.error = "a pose has 7 numbers tx,ty,tz,qx,qy,qz,qw, not " + std::to_string(cells.size());
		return row;
	}
	Fields fields;
	std::copy(cells.begin(), cells.end(), fields.begin());
	return rowOf(fields);
}

Result<std::vector<PoseRow>> readPoses(const std::string& path)
{
	std::ifstream in(systemPath(path));
	if (!in) return Error{"\"" + path + "\" cannot be opened for reading"};
	std::vector<PoseRow> rows;
	std::array<size_t, 7> columns{};
	bool haveHeader = false;
	for (std::string line; std::getline(in, line);)
	{
		if (trimmed(line).empty() || line[0] == '#') continue;
		if (!haveHeader)
		{
			const Result<std::array<size_t, 7>> found = findColumns(path, line);
			if (!found) return found.error();
			columns = found.value();
			haveHeader = true;
			continue;
		}
		const std::vector<std::string_view> cells = splitCommas(line);
		Fields fields;
		for (size_t i = 0; i < fields.size(); ++i) fields[i] = columns[i] < cells.size() ? cells[columns[i]] : std::string_view();
		rows.push_back(rowOf(fields));
	}
	if (in.bad()) return Error{"\"" + path + "\" cannot be read"};
	if (!haveHeader) return Error{"\"" + path + "\" has no header; its first line must name tx,ty,tz,qx,qy,qz,qw"};
	return rows;
}
}  // namespace ist::tools
