// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/ImportApart.h"

#include "BulletISTCollision/Core/Base/Version.h"
#include "BulletISTCollision/Core/Import/ImportPipe.h"
#include "BulletISTCollision/Core/Import/ImporterPath.h"
#include "BulletISTCollision/Core/Import/MeshFileUnit.h"
#include "BulletISTCollision/Core/Platform/ChildProcess.h"

#include <charconv>
#include <utility>

namespace ist
{
namespace
{
/// Longest time until a cancellation takes effect.
constexpr int kPollMilliseconds = 100;

Error noImporter(const std::string& path, const std::string& reason)
{
	return {"cannot read " + path + ": " + meshFileEnding(path) + " files are read by the program bullethaptics-import, " + reason};
}
const char* const kInstall = "; install it with the library, or set BULLETHAPTICS_IMPORT to its path";

/// All digits of a unit, independent of the locale; "stated" stands for the file's own.
std::string unitArgument(const std::optional<double>& unit)
{
	if (!unit) return "stated";
	char text[32];
	return std::string(text, std::to_chars(text, text + sizeof text, *unit).ptr);
}

/// Empty if the process ended without a whole answer.
std::optional<Result<TexturedMesh>> answerOf(ImportPipe& pipe, ImportProgress& importProgress)
{
	for (double fraction = 0;;)
	{
		if (!importProgress.reach(fraction)) return importCancelled();
		if (!pipe.waits(kPollMilliseconds)) continue;
		ImportPipe::Part part{};
		if (!pipe.receivePart(part)) return std::nullopt;
		TexturedMesh textured;
		Error failure;
		switch (part)
		{
		case ImportPipe::Part::Fraction:
			if (!pipe.receiveFraction(fraction)) return std::nullopt;
			continue;
		case ImportPipe::Part::Failure:
			if (!pipe.receiveFailure(failure.message)) return std::nullopt;
			return failure;
		case ImportPipe::Part::Surface:
			if (!pipe.receiveSurface(textured)) return std::nullopt;
			return textured;
		}
		return std::nullopt;
	}
}

/// Why a process ended without an answer.
Error brokeDown(const std::string& path, const std::string& program, const ChildProcess::Status& status)
{
	using enum ChildProcess::Ending;
	if (status.ending == Interrupted) return importCancelled();
	if (status.ending == OutOfTime)
		return {path +
			": reading it takes too long, so it is damaged, or very large: export it again, or set BULLETHAPTICS_IMPORT_SECONDS to the "
			"seconds that it may take"};
	if (status.ending == OutOfMemory) return takesTooMuchMemory(path);
	// The program exits with 2 for arguments of another release.
	if (status.ending == Exited && (status.code == 2 || status.code == kNotRunCode))
		return noImporter(path, "but " + program + " is not that of release " BULLETHAPTICS_VERSION + kInstall);
	return {path + ": the reader of " + meshFileEnding(path) + " files broke down on it, so it is damaged; export it again"};
}
}  // namespace

Result<TexturedMesh> importApart(const std::string& path, const std::optional<double>& unit, Wanted wanted, ImportProgress& importProgress)
{
	const std::string program = importerPath();
#ifdef BULLETHAPTICS_NO_ASSIMP
	if (program.empty())
		return noImporter(
			path, "which this build lacks because it has no assimp; configure it with BULLETHAPTICS_ASSIMP=ON, or export STL, PLY or 3MF");
#endif
	if (program.empty()) return noImporter(path, std::string("which is not there") + kInstall);
	PipeEnd receiving, sending;
	if (const std::error_code failure = PipeEnd::open(receiving, sending))
		return Error{"cannot read " + path + ": " + failure.message() + "; close files and try again"};
	ChildProcess reader;
	const std::error_code failure = reader.start(
		{program, BULLETHAPTICS_VERSION, wanted == Wanted::Surface ? "surface" : "places", unitArgument(unit), path}, sending);
	if (failure) return noImporter(path, "and " + program + " cannot be started (" + failure.message() + ")" + kInstall);
	sending.close();
	ImportPipe pipe(receiving);
	std::optional<Result<TexturedMesh>> answer = answerOf(pipe, importProgress);
	if (!answer) return brokeDown(path, program, reader.wait());
	return *std::move(answer);
}
}  // namespace ist
