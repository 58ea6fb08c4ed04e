// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdio>
#include <optional>

#include <unistd.h>

/// Memory of this process that is resident [bytes]; nothing where the system does not tell.
inline std::optional<long> residentBytes()
{
	FILE* const file = std::fopen("/proc/self/statm", "r");
	if (!file) return std::nullopt;
	long size = 0, resident = 0;
	const bool read = std::fscanf(file, "%ld %ld", &size, &resident) == 2;
	std::fclose(file);
	if (!read) return std::nullopt;
	return resident * sysconf(_SC_PAGESIZE);
}
