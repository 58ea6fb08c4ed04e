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
/// Processor time that reading a file may take [s], and more of it for each byte. Assimp's own test files take at most 0.43 s, and a
/// megabyte takes less than a second.
constexpr double kSeconds = 10, kSecondsOfByte = 1e-5;
/// Memory that reading a file may take [bytes], and more of it for each byte, which may be compressed. Assimp's own test files take at most
/// 108 MB: a file of 86 kB that states a subdivision.
constexpr double kBytes = 1e9, kBytesOfByte = 1000;

std::optional<double> numberOf(const std::string& text)
{
	double value = 0;
	const char* end = text.data() + text.size();
	const std::from_chars_result read = std::from_chars(text.data(), end, value);
	if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
	return value;
}

/// A positive number in a variable of the environment.
std::optional<double> givenBy(const char* variable)
{
	const std::optional<std::string> text = environmentValue(variable);
	const std::optional<double> value = text ? numberOf(*text) : std::nullopt;
	return value && *value > 0 ? value : std::nullopt;
}

/// The limits of this process, which grow with the files that it reads.
class Allowance
{
public:
	explicit Allowance(const std::string& path)
	{
		std::error_code failure;
		const std::uintmax_t size = std::filesystem::file_size(systemPath(path), failure);
		add(failure ? 0 : static_cast<double>(size));
	}
	void add(double bytes)
	{
		m_files += bytes;
		limitProcess(
			m_seconds.value_or(kSeconds + kSecondsOfByte * m_files), m_megabytes ? 1e6 * *m_megabytes : kBytes + kBytesOfByte * m_files);
	}

private:
	const std::optional<double> m_seconds = givenBy("BULLETHAPTICS_IMPORT_SECONDS"),
								m_megabytes = givenBy("BULLETHAPTICS_IMPORT_MEGABYTES");
	double m_files = 0;  ///< size of the files [bytes]
};

bool readAndSend(const std::string& path, std::optional<double> unit, Wanted wanted, const MeshReader& read, ImportPipe& pipe)
try
{
	Allowance allowance(path);
	const Result<TexturedMesh> textured = read(
		path, unit, wanted, [&](const char*, double fraction) { return pipe.sendFraction(fraction); },
		[&](double bytes) { allowance.add(bytes); });
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
	isolateProcess();
	PipeEnd output;
	output.useStandardOutput();
	ImportPipe pipe(output);
	return readAndSend(path, unit, arguments[2] == "places" ? Wanted::SurfaceAndPlaces : Wanted::Surface, read, pipe) ? 0 : 1;
}
}  // namespace ist
