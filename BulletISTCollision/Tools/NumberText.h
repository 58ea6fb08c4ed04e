// SPDX-License-Identifier: Zlib
#pragma once

#include <charconv>
#include <string>
#include <string_view>

namespace ist::tools
{
/// Shortest text that reads back as the same number, independent of the locale.
template <class T> std::string numberText(T value)
{
	char buffer[64];
	const std::to_chars_result end = std::to_chars(buffer, buffer + sizeof buffer, value);
	return std::string(buffer, end.ptr);
}

inline std::string_view trimmed(std::string_view text)
{
	const size_t first = text.find_first_not_of(" \t\r\"");
	if (first == std::string_view::npos) return {};
	return text.substr(first, text.find_last_not_of(" \t\r\"") - first + 1);
}

/// Parses a text that must be exactly one number. Surrounding blanks and a leading + are allowed. Independent of the locale.
inline bool parseNumber(std::string_view text, double& value)
{
	text = trimmed(text);
	if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
	const char* end = text.data() + text.size();
	const std::from_chars_result result = std::from_chars(text.data(), end, value);
	return !text.empty() && result.ec == std::errc() && result.ptr == end;
}
}  // namespace ist::tools
