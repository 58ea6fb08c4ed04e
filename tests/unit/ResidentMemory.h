// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdio>
#include <optional>

#if defined(_WIN32)
#include <windows.h>

#include <psapi.h>
#else
#include <unistd.h>
#endif

/// Memory of this process that is resident [bytes]; nothing where the system does not tell.
inline std::optional<long> residentBytes()
{
#if defined(_WIN32)
	PROCESS_MEMORY_COUNTERS used{};
	used.cb = sizeof used;
	if (K32GetProcessMemoryInfo(GetCurrentProcess(), &used, sizeof used) == 0) return std::nullopt;
	return static_cast<long>(used.WorkingSetSize);
#else
	FILE* const file = std::fopen("/proc/self/statm", "r");
	if (!file) return std::nullopt;
	long size = 0, resident = 0;
	const bool read = std::fscanf(file, "%ld %ld", &size, &resident) == 2;
	std::fclose(file);
	if (!read) return std::nullopt;
	return resident * sysconf(_SC_PAGESIZE);
#endif
}
