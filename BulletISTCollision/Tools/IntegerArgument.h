// SPDX-License-Identifier: Zlib
#pragma once

#include <CLI/CLI.hpp>

#include <charconv>
#include <limits>
#include <string>

namespace ist::tools
{
/// Validator for a decimal integer from `least` to `most`. Use it with Option::transform, which passes on the validated text: CLI alone
/// would read 010 as 8, 0x10 as 16 and -1 as the largest number.
template <class Integer> CLI::Validator integerArgument(Integer least, Integer most = std::numeric_limits<Integer>::max())
{
	const std::string low = std::to_string(least), high = std::to_string(most);
	const bool bounded = most < std::numeric_limits<Integer>::max();
	return CLI::Validator(
		[=](std::string& text) {
			Integer v{};
			const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), v);
			const bool whole = error == std::errc() && end == text.data() + text.size();
			if (!whole || v < least || v > most) return "must be a whole number from " + low + " to " + high;
			text = std::to_string(v);
			return std::string();
		},
		bounded ? "[" + low + " - " + high + "]" : low + " or more");
}
}  // namespace ist::tools
