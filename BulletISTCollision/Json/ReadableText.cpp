// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Json/ReadableText.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

namespace ist
{
namespace
{
constexpr std::string_view kNone = "-";

std::string sixDigits(double value)
{
	char text[32];
	return std::string(text, std::to_chars(text, text + sizeof text, value, std::chars_format::general, 6).ptr);
}

std::string bytesText(double bytes)
{
	constexpr std::array<std::pair<double, const char*>, 3> kUnits = {{{1e9, "GB"}, {1e6, "MB"}, {1e3, "kB"}}};
	for (const auto& [size, name] : kUnits)
		if (bytes >= size) return sixDigits(std::round(bytes / size * 100) / 100) + " " + name;
	return sixDigits(bytes) + " B";
}

/// A number without its unit.
std::string numberWord(const JsonValue& value, std::string_view unit)
{
	if (value.kind() != JsonValue::Kind::Real) return value.dump();
	return sixDigits((unit == "%" ? 100 : 1) * value.number());
}

/// Whether there is nothing to print: null, or a number that is not finite.
bool isNone(const JsonValue& value) { return value.isNull() || (value.kind() == JsonValue::Kind::Real && !std::isfinite(value.number())); }

std::string joined(const JsonValue& list, std::string_view unit);

/// A value on one line, without its unit.
std::string word(const JsonValue& value, std::string_view unit)
{
	if (isNone(value)) return std::string(kNone);
	if (value.isFlag()) return value.flag() ? "yes" : "no";
	if (value.isText()) return value.text();
	if (value.isNumber()) return unit == "B" ? bytesText(value.number()) : numberWord(value, unit);
	if (value.isList()) return value.empty() ? "none" : joined(value, unit);
	std::string text;
	for (const auto& [name, field] : value.fields())
	{
		std::string plain = name;
		std::ranges::replace(plain, '_', ' ');
		text += (text.empty() ? "" : ", ") + plain + " " + word(field, {});
	}
	return text;
}

std::string joined(const JsonValue& list, std::string_view unit)
{
	const bool isPoint = list[0].isNumber();
	std::string text;
	for (const JsonValue& item : list) text += (text.empty() ? "" : isPoint ? ", " : " ") + word(item, unit);
	return isPoint && list.size() > 1 ? "(" + text + ")" : text;
}

/// The name for people, without the unit that ends it.
std::string label(std::string_view field)
{
	std::string text(field);
	if (const std::string unit = unitAtEnd(field); !unit.empty()) text.erase(field.size() - (unit == "rad/s" ? 6 : unit.size() + 1));
	std::ranges::replace(text, '_', ' ');
	return text;
}

/// Number of characters of a text in UTF-8.
size_t width(std::string_view text)
{
	return static_cast<size_t>(std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

std::string padded(std::string text, size_t to)
{
	const size_t is = width(text);
	return text.append(is < to ? to - is : 0, ' ');
}

using Rows = std::vector<std::vector<std::string>>;

/// Lines of rows whose columns stand below each other, each line behind `indentation`.
std::string aligned(const Rows& rows, const std::string& indentation)
{
	std::vector<size_t> widths;
	for (const auto& row : rows)
		for (size_t i = 0; i < row.size(); ++i)
		{
			if (i >= widths.size()) widths.push_back(0);
			widths[i] = std::max(widths[i], width(row[i]));
		}
	std::string text;
	for (const auto& row : rows)
	{
		std::string line = indentation;
		for (size_t i = 0; i < row.size(); ++i) line += i + 1 < row.size() ? padded(row[i], widths[i] + 2) : row[i];
		line.erase(line.find_last_not_of(' ') + 1);
		text += line + "\n";
	}
	return text;
}

std::string table(const JsonValue& list, UnitOf unitOf, const std::string& indentation)
{
	std::vector<std::string> names;
	for (const JsonValue& item : list)
		for (const auto& field : item.fields())
			if (std::ranges::find(names, field.name) == names.end()) names.push_back(field.name);
	Rows rows(1);
	for (const std::string& name : names)
	{
		const std::string unit = unitOf(name);
		rows[0].push_back(label(name) + (unit.empty() || unit == "B" ? "" : " [" + unit + "]"));
	}
	for (const JsonValue& item : list)
	{
		rows.emplace_back();
		for (const std::string& name : names) rows.back().push_back(item.contains(name) ? word(item[name], unitOf(name)) : "");
	}
	return aligned(rows, indentation);
}

/// Rows of a square matrix; empty if the list is none.
Rows matrix(const JsonValue& list)
{
	const size_t side = list.size() == 9 ? 3 : list.size() == 36 ? 6 : 0;
	Rows rows;
	for (size_t i = 0; i < side; ++i)
	{
		rows.emplace_back();
		for (size_t j = 0; j < side; ++j) rows.back().push_back(word(list[i * side + j], {}));
	}
	return rows;
}
}  // namespace

std::string unitAtEnd(std::string_view field)
{
	constexpr std::array<std::pair<std::string_view, const char*>, 5> kEnds = {
		{{"_rad_s", "rad/s"}, {"_us", "us"}, {"_hz", "Hz"}, {"_s", "s"}, {"_m", "m"}}};
	for (const auto& [end, unit] : kEnds)
		if (field.size() > end.size() && field.ends_with(end)) return unit;
	return {};
}

std::string readableText(const JsonValue& report, UnitOf unitOf)
{
	size_t widest = 0;
	for (const auto& [name, value] : report.fields()) widest = std::max(widest, width(label(name)));
	const std::string under(widest + 2, ' ');
	std::string text;
	for (const auto& [name, value] : report.fields())
	{
		if (name == "schema") continue;
		const std::string unit = unitOf(name), head = padded(label(name), widest + 2);
		const bool isList = value.isList() && !value.empty();
		if (isList && value[0].isObject())
		{
			text += label(name) + "\n" + table(value, unitOf, "  ");
			continue;
		}
		std::string lines;
		if (isList && value[0].isText() && value[0].text().find(' ') != std::string::npos)
			for (const JsonValue& sentence : value) lines += under + sentence.text() + "\n";
		else if (isList && value[0].isNumber() && !matrix(value).empty())
			lines = (unit.empty() ? "" : under + "[" + unit + "]\n") + aligned(matrix(value), under);
		else lines = under + word(value, unit) + (unit.empty() || unit == "B" || isNone(value) ? "" : " " + unit) + "\n";
		text += head + lines.substr(under.size());
	}
	return text;
}
}  // namespace ist
