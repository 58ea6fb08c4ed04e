// SPDX-License-Identifier: Zlib
#pragma once

#include <optional>
#include <string>

namespace ist
{
/// Value of a variable of the environment, in UTF-8; nothing if it is not set.
std::optional<std::string> environmentValue(const char* name);
/// Sets a variable that is not set yet. Call it before the program has threads.
void setEnvironmentDefault(const char* name, const char* value);
}  // namespace ist
