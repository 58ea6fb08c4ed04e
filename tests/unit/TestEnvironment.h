// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdlib>

#if defined(_WIN32)
#include <process.h>

// The functions of POSIX by which tests set variables of the environment.
inline int setenv(const char* name, const char* value, int replaces)
{
	return replaces == 0 && std::getenv(name) ? 0 : ::_putenv_s(name, value);
}
inline int unsetenv(const char* name) { return ::_putenv_s(name, ""); }
#else
#include <unistd.h>
#endif
