// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/MappedFile.h"

#include "BulletISTCollision/Core/Base/AlignedBytes.h"
#include "BulletISTCollision/Core/Platform/FileError.h"
#include "BulletISTCollision/Core/Platform/Posix/OpenFile.h"

#include <algorithm>
#include <cstdint>

#include <sys/mman.h>
#include <sys/stat.h>

namespace ist
{
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

Result<MappedFile> MappedFile::open(const std::string& path)
{
	constexpr size_t kChunk = size_t(1) << 22;
	// O_NONBLOCK: opening a pipe must not wait for its writer. Pipes are refused below.
	const OpenFile file(path, O_RDONLY | O_NONBLOCK);
	if (!file.good()) return fileError(path, "opening the file", lastError());
	struct stat about;
	if (::fstat(file.number(), &about) != 0) return fileError(path, "reading the file", lastError());
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
		if (n < 0) return fileError(path, "reading the file", lastError());
		if (n == 0) return Error{"\"" + path + "\" became shorter while it was read"};
		done += static_cast<size_t>(n);
	}
	return content;
}
}  // namespace ist
