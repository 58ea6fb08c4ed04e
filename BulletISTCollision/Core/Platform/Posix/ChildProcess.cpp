// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/ChildProcess.h"

#include <cerrno>
#include <csignal>
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

ChildProcess::Status statusOf(pid_t process)
{
	int status = 0;
	while (::waitpid(process, &status, 0) < 0)
		if (errno != EINTR) return {};
	if (!WIFSIGNALED(status)) return {ChildProcess::Ending::Exited, WEXITSTATUS(status)};
	switch (WTERMSIG(status))
	{
	case SIGINT:
	case SIGTERM: return {ChildProcess::Ending::Interrupted, 0};
	case SIGXCPU: return {ChildProcess::Ending::OutOfTime, 0};
	case SIGKILL: return {ChildProcess::Ending::OutOfMemory, 0};
	default: return {ChildProcess::Ending::Broken, 0};
	}
}
}  // namespace

ChildProcess::~ChildProcess()
{
	if (m_process == kNone) return;
	::kill(static_cast<pid_t>(m_process), SIGKILL);
	(void)wait();
}

std::error_code ChildProcess::start(const std::vector<std::string>& arguments, const PipeEnd& output)
{
	std::vector<char*> list;
	for (const std::string& argument : arguments) list.push_back(const_cast<char*>(argument.c_str()));  // posix_spawn() changes none
	list.push_back(nullptr);
	const SpawnSettings settings(static_cast<int>(output.m_end));
	pid_t process = 0;
	const int failure = ::posix_spawn(&process, list[0], settings.files(), settings.attributes(), list.data(), environ);
	if (failure != 0) return {failure, std::generic_category()};
	m_process = process;
	return {};
}

ChildProcess::Status ChildProcess::wait() { return statusOf(static_cast<pid_t>(std::exchange(m_process, kNone))); }
}  // namespace ist
