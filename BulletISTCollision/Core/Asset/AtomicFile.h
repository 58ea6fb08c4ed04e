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
/// Writes to a temporary file beside `path`, flushes it to the medium and renames it: `path` is either the old file or the whole
/// new one, also when the disk fills up or `progress` (stage "write") cancels. A symbolic link stays a link to the new content,
/// also where nothing stood behind it; a file that is replaced hands on who may read and write it; a device or a pipe is written in place.
/// Gives the number of bytes.
Result<size_t> writeFileAtomically(const std::string& path, const std::byte* bytes, size_t size, const Progress& progress = {});
/// Why writeFileAtomically() would fail now, before anything is spent on what it is to write; null if it would not, as far as can be known:
/// a disk may fill up meanwhile. Leaves nothing behind.
std::optional<Error> whyNotWritable(const std::string& path);

/// Whether writeFileAtomically() of one path would replace what it wrote to the other: a file, however it is named. False for devices and
/// pipes.
bool isSameFile(const std::string& path, const std::string& other);

/// At a multiple of 64; not zeroed. Null when there is not as much.
std::shared_ptr<std::byte> makeAlignedBytes(size_t size);

/// Brings a part of a mapped file into the process at once, in less time than page by page at the first access. Several threads may do
/// so side by side, each with a part of its own.
void populate(const std::byte* bytes, size_t size);

/// The bytes of a file, mapped, or read where the file system cannot map. A file that another program cuts short meanwhile ends
/// the process with SIGBUS, as any mapped file; one that is replaced, as `writeFileAtomically` does, stays whole.
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

	/// At a multiple of 64.
	const std::byte* bytes() const { return m_mapped ? m_mapped : m_read.get(); }
	size_t size() const { return m_size; }

private:
	void swap(MappedFile& other);

	const std::byte* m_mapped = nullptr;
	std::shared_ptr<std::byte> m_read;
	size_t m_size = 0;
};
}  // namespace ist
