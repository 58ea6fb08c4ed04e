// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/WritableFile.h"

#include "BulletISTCollision/Core/Platform/Posix/OpenFile.h"

#include <cstdio>
#include <string>

#include <sys/stat.h>
#if defined(__linux__)
#include <sys/xattr.h>
#endif

namespace ist
{
namespace
{
constexpr int kMostLinks = 40;  // as many symbolic links as the system follows

bool hasAccessList([[maybe_unused]] const char* path)
{
#if defined(__linux__)
	return ::getxattr(path, "system.posix_acl_access", nullptr, 0) > 0;
#else
	return false;
#endif
}

/// Gives `file`, which will replace `old` at `path`, the same owner, group and permissions. If the owner or the group cannot be kept, no
/// further user gets access.
void keepAccess(int file, const struct stat& old, const char* path)
{
	mode_t mode = old.st_mode & 0777;
	// With an access control list, the group bits are the mask of that list, so they are cleared.
	if (hasAccessList(path) || ::fchown(file, uid_t(-1), old.st_gid) != 0) mode &= ~mode_t(0070);
	(void)::fchmod(file, mode);
	(void)!::fchown(file, old.st_uid, gid_t(-1));
}
}  // namespace

WritableFile::~WritableFile()
{
	(void)close();
	if (!m_created.empty()) ::unlink(m_created.c_str());
}

std::error_code WritableFile::createBeside(const std::filesystem::path& target)
{
	struct stat old;
	const bool replaces = ::stat(target.c_str(), &old) == 0;
	// No two writers share a name, neither threads of a process nor processes with the same number in two containers. It is short, because
	// the target's may be as long as the system allows.
	const std::string stem = (target.parent_path() / (".tmp" + std::to_string(::getpid()) + "_")).string();
	for (unsigned long i = 0;; ++i)
	{
		const std::string name = stem + std::to_string(i);
		OpenFile file(name, O_WRONLY | O_CREAT | O_EXCL, replaces ? 0600 : 0666);
		if (!file.good() && errno == EEXIST) continue;
		if (!file.good()) return lastError();
		if (replaces) keepAccess(file.number(), old, target.c_str());
		m_file = file.release();
		m_target = target;
		m_created = name;
		return {};
	}
}

std::error_code WritableFile::openInPlace(const std::filesystem::path& path)
{
	OpenFile file(path, O_WRONLY);
	if (!file.good()) return lastError();
	m_file = file.release();
	return {};
}

std::error_code WritableFile::write(const std::byte* bytes, std::size_t size, std::size_t& written)
{
	for (;;)
	{
		const ssize_t n = ::write(static_cast<int>(m_file), bytes, size);
		if (n < 0 && errno == EINTR) continue;
		if (n == 0) return std::make_error_code(std::errc::no_space_on_device);
		if (n < 0) return lastError();
		written = static_cast<std::size_t>(n);
		return {};
	}
}

std::error_code WritableFile::replaceTarget()
{
	if (::fsync(static_cast<int>(m_file)) != 0) return lastError();
	if (const std::error_code failure = close()) return failure;
	if (std::rename(m_created.c_str(), m_target.c_str()) != 0) return lastError();
	m_created.clear();
	return {};
}

std::error_code WritableFile::close()
{
	OpenFile file(static_cast<int>(m_file));
	m_file = -1;
	return file.close() ? std::error_code() : lastError();
}

bool isDeviceOrPipe(const std::filesystem::path& path)
{
	using enum std::filesystem::file_type;
	std::error_code failure;
	const std::filesystem::file_type type = std::filesystem::status(path, failure).type();
	return type != none && type != not_found && type != regular && type != directory;
}

std::filesystem::path behindLinks(std::filesystem::path path)
{
	std::error_code isNoLink;
	for (int links = 0; links < kMostLinks; ++links)
	{
		const std::filesystem::path next = std::filesystem::read_symlink(path, isNoLink);
		if (isNoLink) return path;
		path = path.parent_path() / next;
	}
	return path;
}

std::error_code whyNotWritableInPlace(const std::filesystem::path& path)
{
	return ::access(path.c_str(), W_OK) == 0 ? std::error_code() : lastError();
}
}  // namespace ist
