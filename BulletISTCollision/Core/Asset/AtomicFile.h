// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

namespace ist
{
/// Writes to a temporary file beside `path`, flushes it to the medium and renames it. So `path` is either the old file or the complete
/// new one, even if the disk fills up or `progress` (stage "write") cancels. A symbolic link is kept and leads to the new content, even
/// if its target did not exist. A replaced file passes on its access rights. A device or a pipe is written in place. Returns the number
/// of bytes.
Result<size_t> writeFileAtomically(const std::string& path, const std::byte* bytes, size_t size, const Progress& progress = {});
/// The error that writeFileAtomically() would return now; null if none can be foreseen. Call it before expensive work whose result is to
/// be written. A disk may still fill up meanwhile. Leaves nothing behind.
std::optional<Error> whyNotWritable(const std::string& path);

/// Whether writeFileAtomically() on one path would replace what it wrote to the other: true for one file under two names. False for
/// devices and pipes.
bool isSameFile(const std::string& path, const std::string& other);

/// Bytes at an address that is a multiple of 64; not zeroed. Null if memory runs out.
std::shared_ptr<std::byte> makeAlignedBytes(size_t size);

/// Makes a part of a mapped file resident at once, which takes less time than a page fault for each page. Several threads may do so in
/// parallel, each with its own part.
void populate(const std::byte* bytes, size_t size);

/// The bytes of a file, mapped, or read if the file system cannot map. If another program truncates the file meanwhile, the process ends
/// with SIGBUS, as for any mapped file. A file that is replaced, as `writeFileAtomically` does, stays intact.
class MappedFile
{
public:
	static Result<MappedFile> open(const std::string& path);
	MappedFile() = default;
	MappedFile(MappedFile&& other) noexcept { swap(other); }
	MappedFile& operator=(MappedFile&& other) noexcept
	{
		swap(other);
		return *this;
	}
	~MappedFile();

	/// The bytes; their address is a multiple of 64.
	const std::byte* bytes() const { return m_mapped ? m_mapped : m_read.get(); }
	size_t size() const { return m_size; }

private:
	void swap(MappedFile& other);

	const std::byte* m_mapped = nullptr;
	std::shared_ptr<std::byte> m_read;
	size_t m_size = 0;
};
}  // namespace ist
