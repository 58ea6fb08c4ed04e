// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Importer/Importer.h"

#include "BulletISTCollision/Core/Base/Version.h"
#include "BulletISTCollision/Core/Import/ImportPipe.h"
#include "BulletISTCollision/Core/Platform/CommandProcess.h"
#include "BulletISTCollision/Core/Platform/Environment.h"
#include "BulletISTCollision/Core/Platform/ProcessLimits.h"
#include "BulletISTCollision/Core/Platform/Utf8Path.h"

#include <charconv>
#include <cstdio>
#include <filesystem>
#include <new>
#include <system_error>

namespace ist
{
namespace
{
/// Share of the machine's memory that reading a file may take.
constexpr double kMemoryShare = 0.75;
/// Processor time that reading a file may take [s], and more of it for each byte: assimp reads a megabyte in less than a second.
constexpr double kSeconds = 60, kSecondsOfByte = 1e-5;

std::optional<double> numberOf(const std::string& text)
{
	double value = 0;
	const char* end = text.data() + text.size();
	const std::from_chars_result read = std::from_chars(text.data(), end, value);
	if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
	return value;
}

double secondsFor(const std::string& path)
{
	const std::optional<std::string> given = environmentValue("BULLETHAPTICS_IMPORT_SECONDS");
	if (const std::optional<double> seconds = given ? numberOf(*given) : std::nullopt; seconds && *seconds > 0) return *seconds;
	std::error_code failure;
	const std::uintmax_t size = std::filesystem::file_size(systemPath(path), failure);
	return failure ? kSeconds : kSeconds + kSecondsOfByte * static_cast<double>(size);
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
	const std::vector<std::string> arguments = commandArguments(argc, argv);
	const bool isOurs = arguments.size() == 5 && arguments[1] == BULLETHAPTICS_VERSION;
	const std::optional<double> unit = isOurs ? numberOf(arguments[3]) : std::nullopt;
	if (!isOurs || (!unit && arguments[3] != "stated"))
	{
		std::fputs("bullethaptics-import " BULLETHAPTICS_VERSION
				   " reads mesh files for the BulletHaptics library of this release, which starts it; to try a file, call ist build\n",
			stderr);
		return 2;
	}
	const std::string path = arguments[4];
	limitProcess(secondsFor(path), kMemoryShare);
	PipeEnd output;
	output.useStandardOutput();
	ImportPipe pipe(output);
	return readAndSend(path, unit, arguments[2] == "places" ? Wanted::SurfaceAndPlaces : Wanted::Surface, read, pipe) ? 0 : 1;
}
}  // namespace ist
