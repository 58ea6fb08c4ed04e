// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/ImportApart.h"

#include "BulletISTCollision/Core/Base/Version.h"
#include "BulletISTCollision/Core/Import/ImportPipe.h"
#include "BulletISTCollision/Core/Import/ImporterPath.h"
#include "BulletISTCollision/Core/Import/MeshFileUnit.h"

#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

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

/// The attributes and file actions of a process: its output goes into the pipe and its messages nowhere, and signals have their default.
class SpawnSettings
{
public:
	explicit SpawnSettings(int output)
	{
		::posix_spawn_file_actions_init(&m_files);
		// First, because the pipe may have the number of a standard stream that the program closed.
		::posix_spawn_file_actions_adddup2(&m_files, output, STDOUT_FILENO);
		::posix_spawn_file_actions_addopen(&m_files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
// Sanitizers write what they find to stderr.
#ifndef BULLETHAPTICS_SANITIZED
		::posix_spawn_file_actions_addopen(&m_files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
#endif
		::posix_spawnattr_init(&m_attributes);
		sigset_t none, all;
		sigemptyset(&none);
		sigfillset(&all);
		::posix_spawnattr_setsigmask(&m_attributes, &none);
		::posix_spawnattr_setsigdefault(&m_attributes, &all);
		::posix_spawnattr_setflags(&m_attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
	}
	~SpawnSettings()
	{
		::posix_spawn_file_actions_destroy(&m_files);
		::posix_spawnattr_destroy(&m_attributes);
	}
	SpawnSettings(const SpawnSettings&) = delete;
	SpawnSettings& operator=(const SpawnSettings&) = delete;
	const posix_spawn_file_actions_t* files() const { return &m_files; }
	const posix_spawnattr_t* attributes() const { return &m_attributes; }

private:
	posix_spawn_file_actions_t m_files;
	posix_spawnattr_t m_attributes;
};

/// The process of the importer program. It is ended with this object.
class Reader
{
public:
	~Reader()
	{
		if (m_process > 0) end();
	}
	/// Returns 0, or an error number.
	int start(const std::array<std::string, 5>& arguments, int output)
	{
		std::array<char*, 6> list{};
		for (size_t i = 0; i < arguments.size(); ++i) list[i] = const_cast<char*>(arguments[i].c_str());  // posix_spawn() changes none
		const SpawnSettings settings(output);
		return ::posix_spawn(&m_process, list[0], settings.files(), settings.attributes(), list.data(), environ);
	}
	/// Ends the process if it runs. Returns its status; 0 if the program waits for its children elsewhere.
	int end()
	{
		const pid_t process = std::exchange(m_process, 0);
		::kill(process, SIGKILL);
		return statusOf(process);
	}
	int wait() { return statusOf(std::exchange(m_process, 0)); }

private:
	static int statusOf(pid_t process)
	{
		int status = 0;
		while (::waitpid(process, &status, 0) < 0)
			if (errno != EINTR) return 0;
		return status;
	}
	pid_t m_process = 0;
};

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
Error brokeDown(const std::string& path, const std::string& program, int status)
{
	const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
	if (signal == SIGINT || signal == SIGTERM) return importCancelled();
	if (signal == SIGXCPU)
		return {path +
			": reading it takes too long, so it is damaged, or very large: export it again, or set BULLETHAPTICS_IMPORT_SECONDS to the "
			"seconds that it may take"};
	if (signal == SIGKILL) return takesTooMuchMemory(path);
	// Exit codes of the program for arguments of another release, and of posix_spawn() where the program cannot be run.
	if (WIFEXITED(status) && (WEXITSTATUS(status) == 2 || WEXITSTATUS(status) == 127))
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
	int ends[2];
	if (::pipe2(ends, O_CLOEXEC) != 0) return Error{"cannot read " + path + ": " + std::strerror(errno) + "; close files and try again"};
#ifdef F_SETPIPE_SZ
	(void)::fcntl(ends[1], F_SETPIPE_SZ, 1 << 20);
#endif
	ImportPipe in(ends[0]), out(ends[1]);
	Reader reader;
	const int failed = reader.start(
		{program, BULLETHAPTICS_VERSION, wanted == Wanted::Surface ? "surface" : "places", unitArgument(unit), path}, ends[1]);
	if (failed != 0) return noImporter(path, "and " + program + " cannot be started (" + std::strerror(failed) + ")" + kInstall);
	out.close();
	std::optional<Result<TexturedMesh>> answer = answerOf(in, importProgress);
	if (!answer) return brokeDown(path, program, reader.wait());
	return *std::move(answer);
}
}  // namespace ist
