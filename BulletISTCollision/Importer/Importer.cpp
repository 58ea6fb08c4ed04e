// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Importer/Importer.h"

#include "BulletISTCollision/Core/Base/Version.h"
#include "BulletISTCollision/Core/Import/ImportPipe.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <new>
#include <system_error>

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

namespace ist
{
namespace
{
/// Share of the machine's memory that reading a file may take.
constexpr double kMemoryShare = 0.75;
/// Processor time that reading a file may take [s], and more of it for each byte: assimp reads a megabyte in less than a second.
constexpr double kSeconds = 60, kSecondsOfByte = 1e-5;

std::optional<double> numberOf(const char* text)
{
	double value = 0;
	const char* end = text + std::strlen(text);
	const std::from_chars_result read = std::from_chars(text, end, value);
	if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
	return value;
}

double secondsFor(const std::string& path)
{
	const char* given = std::getenv("BULLETHAPTICS_IMPORT_SECONDS");
	if (const std::optional<double> seconds = given ? numberOf(given) : std::nullopt; seconds && *seconds > 0) return *seconds;
	std::error_code failure;
	const std::uintmax_t size = std::filesystem::file_size(path, failure);
	return failure ? kSeconds : kSeconds + kSecondsOfByte * static_cast<double>(size);
}

void limit(int resource, double most)
{
	rlimit now{};
	getrlimit(resource, &now);
	if (most < static_cast<double>(now.rlim_cur)) now.rlim_cur = static_cast<rlim_t>(std::max(1.0, most));
	setrlimit(resource, &now);
}

/// Limits what a damaged file can take, and leaves no dump behind.
void confine(const std::string& path)
{
	// Files and devices of the program that started this one.
#ifdef __linux__
	::close_range(STDERR_FILENO + 1, ~0u, 0);
#endif
	limit(RLIMIT_CPU, secondsFor(path));
	const rlimit none{0, 0};
	setrlimit(RLIMIT_CORE, &none);
// Sanitizers map terabytes.
#ifndef BULLETHAPTICS_SANITIZED
	limit(RLIMIT_AS, kMemoryShare * static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE)));
#endif
}

bool readAndSend(const std::string& path, std::optional<double> unit, Wanted wanted, const MeshReader& read, ImportPipe& pipe)
try
{
	const Result<TexturedMesh> textured = read(
		path, unit, wanted, [&](const char*, double fraction) { return pipe.sendFraction(fraction); });
	return textured ? pipe.sendSurface(textured.value()) : pipe.sendFailure(textured.error().message);
}
catch (const std::bad_alloc&)
{
	return pipe.sendFailure(takesTooMuchMemory(path).message);
}
}  // namespace

int runImporter(int argc, char** argv, const MeshReader& read)
{
	const bool isOurs = argc == 5 && std::strcmp(argv[1], BULLETHAPTICS_VERSION) == 0;
	const std::optional<double> unit = isOurs ? numberOf(argv[3]) : std::nullopt;
	if (!isOurs || (!unit && std::strcmp(argv[3], "stated") != 0))
	{
		std::fputs("bullethaptics-import " BULLETHAPTICS_VERSION
				   " reads mesh files for the BulletHaptics library of this release, which starts it; to try a file, call ist build\n",
			stderr);
		return 2;
	}
	const std::string path = argv[4];
	confine(path);
	ImportPipe pipe(STDOUT_FILENO);
	return readAndSend(path, unit, std::strcmp(argv[2], "places") == 0 ? Wanted::SurfaceAndPlaces : Wanted::Surface, read, pipe) ? 0 : 1;
}
}  // namespace ist
