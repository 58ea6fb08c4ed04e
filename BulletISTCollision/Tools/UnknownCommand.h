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
	const auto nearest = std::ranges::min_element(commands, {}, [&](const std::string& command) { return editDistance(word, command); });
	std::string all;
	for (const std::string& command : commands) all += (all.empty() ? "" : ", ") + command;
	return "there is no command \"" + std::string(word) + "\"; the nearest is \"" + *nearest + "\", and all are: " + all;
}
}  // namespace ist::tools
