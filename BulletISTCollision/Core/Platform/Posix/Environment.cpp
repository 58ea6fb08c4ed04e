// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/Environment.h"

#include <cstdlib>

namespace ist
{
std::optional<std::string> environmentValue(const char* name)
{
	const char* const value = std::getenv(name);
	return value ? std::optional<std::string>(value) : std::nullopt;
}

void setEnvironmentDefault(const char* name, const char* value) { ::setenv(name, value, 0); }
}  // namespace ist
