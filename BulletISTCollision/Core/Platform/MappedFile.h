// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"

#include <cstddef>
#include <memory>
#include <string>
#include <utility>

namespace ist
{
/// Makes a part of a mapped file resident at once, which takes less time than a page fault for each page. Several threads may do so in
/// parallel, each with its own part.
void populate(const std::byte* bytes, size_t size);

/// The bytes of a file, mapped, or read if the file system cannot map. If another program truncates the file meanwhile, the process ends
/// with SIGBUS, as for any mapped file; Windows refuses to truncate it. A file that is replaced, as `writeFileAtomically` does, stays
/// intact.
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
	void swap(MappedFile& other) noexcept
	{
		std::swap(m_mapped, other.m_mapped);
		std::swap(m_read, other.m_read);
		std::swap(m_size, other.m_size);
	}

	const std::byte* m_mapped = nullptr;
	std::shared_ptr<std::byte> m_read;
	size_t m_size = 0;
};
}  // namespace ist
