// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Json/EditDistance.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace ist::tools
{
/// The sentence about a first argument that is neither an option nor a command; empty if it is one of them.
inline std::string unknownCommand(std::string_view word, const std::vector<std::string>& commands)
{
	if (word.empty() || word.front() == '-' || std::ranges::find(commands, word) != commands.end()) return {};
	const auto distance = [&](const std::string& command) { return editDistance(word, command); };
	const auto nearest = std::ranges::min_element(commands, {}, distance);
	// A word that shares fewer letters with every command is no misspelling of one. Of short words, two letters may be swapped.
	const bool isNear = nearest != commands.end() && distance(*nearest) <= std::max<size_t>(2, nearest->size() / 3) &&
		distance(*nearest) < std::min(word.size(), nearest->size());
	std::string all;
	for (const std::string& command : commands) all += (all.empty() ? "" : ", ") + command;
	return "there is no command \"" + std::string(word) +
		(isNear ? "\"; the nearest is \"" + *nearest + "\", and all are: " : "\"; all are: ") + all;
}
}  // namespace ist::tools
