// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Preload/PackingQueue.h"

#include "BulletISTCollision/Core/Base/SteadyTime.h"
#include "BulletISTCollision/Core/Platform/InstalledProgram.h"

#include <cerrno>
#include <csignal>
#include <cstring>

#include <fcntl.h>
#include <spawn.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace preload
{
namespace
{
constexpr double kMicrosecondsBetweenLooks = 50000;
/// A packer that ends without carrying out an order is started again so many times.
constexpr int kMostStartsInVain = 3;

bool isThere(const std::filesystem::path& path)
{
	std::error_code ignored;
	return std::filesystem::exists(path, ignored);
}

/// The environment without this library, which the packer does not need.
std::vector<char*> packersEnvironment()
{
	std::vector<char*> result;
	for (char** each = environ; each && *each; ++each)
		if (std::strncmp(*each, "LD_PRELOAD=", 11) != 0) result.push_back(*each);
	result.push_back(nullptr);
	return result;
}

/// Starts a program in a session of its own, without the files of this process except `kept`, which becomes its file 3. Returns why it
/// failed, else 0. The program must soon end in this process and go on in a child, so that the game gets no child that it does not know.
int startApart(const std::vector<std::string>& arguments, int kept)
{
	std::vector<char*> list;
	for (const std::string& argument : arguments) list.push_back(const_cast<char*>(argument.c_str()));  // posix_spawn() changes none
	list.push_back(nullptr);
	posix_spawn_file_actions_t files;
	posix_spawn_file_actions_init(&files);
	// First, because the lock may have the number of a standard stream that the game closed.
	posix_spawn_file_actions_adddup2(&files, kept, STDERR_FILENO + 1);
	for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
		posix_spawn_file_actions_addopen(&files, stream, "/dev/null", O_RDWR, 0);
	posix_spawnattr_t attributes;
	posix_spawnattr_init(&attributes);
	sigset_t none, all;
	sigemptyset(&none);
	sigfillset(&all);
	posix_spawnattr_setsigmask(&attributes, &none);
	posix_spawnattr_setsigdefault(&attributes, &all);
	posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSID);
	pid_t process = 0;
	const int failure = posix_spawn(&process, list[0], &files, &attributes, list.data(), packersEnvironment().data());
	posix_spawn_file_actions_destroy(&files);
	posix_spawnattr_destroy(&attributes);
	if (failure != 0) return failure;
	while (waitpid(process, nullptr, 0) < 0 && errno == EINTR)
	{}
	return 0;
}
}  // namespace

PackingQueue::PackingQueue(const Settings& settings) : m_settings(settings), m_files(settings.cacheFolder)
{
	if (settings.cacheFolder.empty() || !settings.packs) return;
	std::error_code failure;
	std::filesystem::create_directories(m_files.folder(), failure);
	const std::filesystem::path here = ist::fileOfFunction(reinterpret_cast<const void*>(&buildOptions));
	m_program = here.parent_path() / "bullethaptics-pack";
	m_usable = true;
	if (here.empty()) giveUp("this library cannot find its own file, and so not the program beside it");
	else if (failure) giveUp(m_files.folder().string() + ": " + failure.message());
	else if (access(m_program.c_str(), X_OK) != 0) giveUp(m_program.string() + ": " + std::strerror(errno));
}

void PackingQueue::giveUp(const std::string& reason)
{
	if (m_usable) say(m_settings, 2, "trees are packed inside of this program, and a half of one is lost when it ends: " + reason);
	m_usable = false;
}

std::string PackingQueue::order(ist::Mesh mesh)
{
	if (!m_usable) return {};
	const PackingOrder order{std::move(mesh), m_settings.spheres};
	std::string key = order.key();
	if (isThere(m_files.tree(key))) return {};
	if (!isThere(m_files.wanted(key)) && !order.write(m_files.wanted(key)))
	{
		giveUp(m_files.folder().string() + " cannot be written");
		return {};
	}
	return packerWorks() ? key : std::string();
}

void PackingQueue::withdraw(const std::string& key)
{
	std::error_code ignored;
	std::filesystem::remove(m_files.wanted(key), ignored);
}

bool PackingQueue::packerWorks()
{
	if (!m_usable) return false;
	const int lock = open(m_files.lock().c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
	if (lock < 0) giveUp(m_files.lock().string() + ": " + std::strerror(errno));
	else if (flock(lock, LOCK_EX | LOCK_NB) != 0)
	{
		if (errno != EWOULDBLOCK) giveUp(m_files.lock().string() + ": " + std::strerror(errno));
	}
	else if (++m_startsInVain > kMostStartsInVain) giveUp(m_program.string() + " ended several times before it was done");
	// The packer inherits the lock, and holds it until it ends.
	else if (const int failure = startApart({m_program.string(), m_files.folder().string(), m_settings.waits ? "0" : "10"}, lock))
		giveUp(m_program.string() + ": " + std::strerror(failure));
	if (lock >= 0) close(lock);
	return m_usable;
}

std::vector<std::string> PackingQueue::over(const std::vector<std::string>& keys)
{
	const double now = ist::steadyMicroseconds();
	if (keys.empty() || now < m_nextLook) return {};
	m_nextLook = now + kMicrosecondsBetweenLooks;
	if (!packerWorks()) return keys;
	std::vector<std::string> result;
	for (const std::string& key : keys)
		if (!isThere(m_files.wanted(key)) && !isThere(m_files.taken(key))) result.push_back(key);
	if (!result.empty()) m_startsInVain = 0;
	return result;
}
}  // namespace preload
