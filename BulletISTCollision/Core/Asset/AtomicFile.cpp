// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Asset/AtomicFile.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <new>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#if defined(__linux__)
#include <sys/xattr.h>
#endif
#include <unistd.h>

namespace ist
{
namespace
{
constexpr size_t kChunk = size_t(1) << 22;
constexpr int kMostLinks = 40;  // as many symbolic links as the system follows

Error systemError(const std::string& path, const char* doing, int reason)
{
	return {"\"" + path + "\": " + doing + " failed: " + std::strerror(reason)};
}

class OpenFile
{
public:
	explicit OpenFile(int number) : m_file(number) {}
	OpenFile(const std::string& path, int flags) : m_file(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
	~OpenFile() { close(); }
	OpenFile(const OpenFile&) = delete;
	OpenFile& operator=(const OpenFile&) = delete;

	bool good() const { return m_file >= 0; }
	int number() const { return m_file; }
	/// Some systems report a full disk only when the file is closed.
	bool close()
	{
		const int file = m_file;
		m_file = -1;
		return file < 0 || ::close(file) == 0;
	}

private:
	int m_file;
};

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

/// Creates a file beside `target`, which grants no more access than the present file does. No two writers share one, neither threads of a
/// process nor processes with the same number in two containers. Its name is short, because the target's may be as long as the system
/// allows.
int createBeside(const std::filesystem::path& target, std::string& name)
{
	struct stat old;
	const bool replaces = ::stat(target.c_str(), &old) == 0;
	const std::string stem = (target.parent_path() / (".tmp" + std::to_string(::getpid()) + "_")).string();
	for (unsigned long i = 0;; ++i)
	{
		name = stem + std::to_string(i);
		const int file = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, replaces ? 0600 : 0666);
		if (file < 0 && errno == EEXIST) continue;
		if (file >= 0 && replaces) keepAccess(file, old, target.c_str());
		return file;
	}
}

enum class Outcome
{
	Done,
	Failed,  ///< errno holds the reason
	Cancelled
};

Outcome writeAll(const OpenFile& file, const std::byte* bytes, size_t size, const Progress& progress)
{
	for (size_t done = 0; done < size;)
	{
		if (progress && !progress("write", double(done) / double(size))) return Outcome::Cancelled;
		const ssize_t n = ::write(file.number(), bytes + done, std::min(kChunk, size - done));
		if (n < 0 && errno == EINTR) continue;
		if (n == 0) errno = ENOSPC;
		if (n <= 0) return Outcome::Failed;
		done += static_cast<size_t>(n);
	}
	return progress && !progress("write", 1) ? Outcome::Cancelled : Outcome::Done;
}

Result<size_t> result(Outcome outcome, const std::string& path, size_t size, int reason)
{
	if (outcome == Outcome::Done) return size;
	if (outcome == Outcome::Cancelled) return Error{"\"" + path + "\": the writing was cancelled; nothing was written", true};
	return systemError(path, "writing the file", reason);
}

Result<size_t> writeInPlace(const std::string& path, const std::byte* bytes, size_t size, const Progress& progress)
{
	OpenFile file(path, O_WRONLY);
	if (!file.good()) return systemError(path, "opening the file", errno);
	Outcome outcome = writeAll(file, bytes, size, progress);
	int reason = errno;
	if (!file.close() && outcome == Outcome::Done)
	{
		outcome = Outcome::Failed;
		reason = errno;
	}
	return result(outcome, path, size, reason);
}

bool isDeviceOrPipe(std::filesystem::file_type type)
{
	using enum std::filesystem::file_type;
	return type != none && type != not_found && type != regular && type != directory;
}

/// Target of symbolic links, also if it does not exist yet.
std::filesystem::path followed(std::filesystem::path path)
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

/// Type of the file at `path`, behind any symbolic links, if it can be written.
Result<std::filesystem::file_type> targetType(const std::string& path)
{
	if (path.empty()) return Error{"the file to write has no name; give it one"};
	std::error_code reason;
	const std::filesystem::file_type there = std::filesystem::status(path, reason).type();
	if (there == std::filesystem::file_type::directory) return systemError(path, "writing the file", EISDIR);
	if (there == std::filesystem::file_type::none) return systemError(path, "writing the file", reason.value());
	return there;
}
}  // namespace

std::optional<Error> whyNotWritable(const std::string& path)
{
	const Result<std::filesystem::file_type> there = targetType(path);
	if (!there) return there.error();
	if (isDeviceOrPipe(there.value()))
	{
		// A pipe is not opened: that would wait for its reader, and closing it again would end the reader's input.
		if (::access(path.c_str(), W_OK) != 0) return systemError(path, "opening the file", errno);
		return std::nullopt;
	}
	std::string temporary;
	const OpenFile file(createBeside(followed(path), temporary));
	if (!file.good()) return systemError(path, "creating the file", errno);
	::unlink(temporary.c_str());
	return std::nullopt;
}

Result<size_t> writeFileAtomically(const std::string& path, const std::byte* bytes, size_t size, const Progress& progress)
{
	const Result<std::filesystem::file_type> there = targetType(path);
	if (!there) return there.error();
	if (isDeviceOrPipe(there.value())) return writeInPlace(path, bytes, size, progress);

	const std::filesystem::path target = followed(path);
	std::string temporary;
	OpenFile file(createBeside(target, temporary));
	if (!file.good()) return systemError(path, "creating the file", errno);
	Outcome outcome = writeAll(file, bytes, size, progress);
	if (outcome == Outcome::Done && (::fsync(file.number()) != 0 || !file.close() || ::rename(temporary.c_str(), target.c_str()) != 0))
		outcome = Outcome::Failed;
	const int reason = errno;
	if (outcome != Outcome::Done) ::unlink(temporary.c_str());
	return result(outcome, path, size, reason);
}

bool isSameFile(const std::string& path, const std::string& other)
{
	std::error_code unknown;
	if (isDeviceOrPipe(std::filesystem::status(path, unknown).type())) return false;
	const auto place = [&](const std::string& p) {
		return std::filesystem::weakly_canonical(std::filesystem::absolute(followed(p), unknown), unknown);
	};
	return place(path) == place(other);
}

std::shared_ptr<std::byte> makeAlignedBytes(size_t size)
{
	constexpr std::align_val_t line{64};
	auto* bytes = static_cast<std::byte*>(::operator new(size, line, std::nothrow));
	if (!bytes) return nullptr;
	return {bytes, [](std::byte* p) { ::operator delete(p, line); }};
}

void populate([[maybe_unused]] const std::byte* bytes, [[maybe_unused]] size_t size)
{
#ifdef MADV_POPULATE_READ
	const size_t page = size_t(::sysconf(_SC_PAGESIZE)), before = reinterpret_cast<uintptr_t>(bytes) % page;
	// If the system cannot do this, the first access to each page loads it.
	if (size > 0) (void)::madvise(const_cast<std::byte*>(bytes - before), size + before, MADV_POPULATE_READ);
#endif
}

MappedFile::~MappedFile()
{
	if (m_mapped) ::munmap(const_cast<std::byte*>(m_mapped), m_size);
}

void MappedFile::swap(MappedFile& other)
{
	std::swap(m_mapped, other.m_mapped);
	std::swap(m_read, other.m_read);
	std::swap(m_size, other.m_size);
}

Result<MappedFile> MappedFile::open(const std::string& path)
{
	// O_NONBLOCK: opening a pipe must not wait for its writer. Pipes are refused below.
	const OpenFile file(path, O_RDONLY | O_NONBLOCK);
	if (!file.good()) return systemError(path, "opening the file", errno);
	struct stat about;
	if (::fstat(file.number(), &about) != 0) return systemError(path, "reading the file", errno);
	if (!S_ISREG(about.st_mode)) return Error{"\"" + path + "\" is not a file"};
	MappedFile content;
	content.m_size = static_cast<size_t>(about.st_size);
	void* mapped = ::mmap(nullptr, content.m_size, PROT_READ, MAP_PRIVATE, file.number(), 0);
	if (mapped != MAP_FAILED)
	{
		content.m_mapped = static_cast<const std::byte*>(mapped);
		return content;
	}
	content.m_read = makeAlignedBytes(content.m_size);
	if (!content.m_read) return Error{"\"" + path + "\": not enough memory to read it"};
	for (size_t done = 0; done < content.m_size;)
	{
		const ssize_t n = ::read(file.number(), content.m_read.get() + done, std::min(kChunk, content.m_size - done));
		if (n < 0 && errno == EINTR) continue;
		if (n < 0) return systemError(path, "reading the file", errno);
		if (n == 0) return Error{"\"" + path + "\" became shorter while it was read"};
		done += static_cast<size_t>(n);
	}
	return content;
}
}  // namespace ist
