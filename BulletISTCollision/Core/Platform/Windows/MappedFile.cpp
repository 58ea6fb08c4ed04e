// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/MappedFile.h"

#include "BulletISTCollision/Core/Base/AlignedBytes.h"
#include "BulletISTCollision/Core/Platform/FileError.h"
#include "BulletISTCollision/Core/Platform/Windows/OpenHandle.h"

#include <algorithm>

namespace ist
{
namespace
{
/// Opens a file to read it. Waits while another program replaces it.
HANDLE openToRead(const std::wstring& path)
{
	constexpr int kTries = 50;
	for (int i = 0;; ++i)
	{
		// FILE_SHARE_DELETE: the file may be replaced while it is mapped.
		const HANDLE file = ::CreateFileW(path.c_str(), GENERIC_READ, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, nullptr,
			OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, nullptr);
		if (file != INVALID_HANDLE_VALUE || ::GetLastError() != ERROR_SHARING_VIOLATION || i == kTries) return file;
		::Sleep(static_cast<DWORD>(i / 5));
	}
}
}  // namespace

void populate(const std::byte* bytes, size_t size)
{
	// If the system cannot do this, the first access to each page loads it.
	WIN32_MEMORY_RANGE_ENTRY range{const_cast<std::byte*>(bytes), size};
	if (size > 0) (void)::PrefetchVirtualMemory(::GetCurrentProcess(), 1, &range, 0);
}

MappedFile::~MappedFile()
{
	if (m_mapped) ::UnmapViewOfFile(m_mapped);
}

Result<MappedFile> MappedFile::open(const std::string& path)
{
	constexpr size_t kChunk = size_t(1) << 22;
	const OpenHandle file(openToRead(wide(path)));
	if (!file.good())
	{
		const std::error_code reason = lastError();
		const DWORD attributes = ::GetFileAttributesW(wide(path).c_str());
		if (attributes != INVALID_FILE_ATTRIBUTES && (attributes & FILE_ATTRIBUTE_DIRECTORY))
			return Error{"\"" + path + "\" is not a file"};
		return fileError(path, "opening the file", reason);
	}
	if (::GetFileType(file.get()) != FILE_TYPE_DISK) return Error{"\"" + path + "\" is not a file"};
	LARGE_INTEGER length{};
	if (::GetFileSizeEx(file.get(), &length) == 0) return fileError(path, "reading the file", lastError());
	MappedFile content;
	content.m_size = static_cast<size_t>(length.QuadPart);
	const OpenHandle mapping(content.m_size == 0 ? nullptr : ::CreateFileMappingW(file.get(), nullptr, PAGE_READONLY, 0, 0, nullptr));
	if (mapping.good()) content.m_mapped = static_cast<const std::byte*>(::MapViewOfFile(mapping.get(), FILE_MAP_READ, 0, 0, 0));
	if (content.m_mapped) return content;
	content.m_read = makeAlignedBytes(content.m_size);
	if (!content.m_read) return Error{"\"" + path + "\": not enough memory to read it"};
	for (size_t done = 0; done < content.m_size;)
	{
		DWORD n = 0;
		if (::ReadFile(file.get(), content.m_read.get() + done, static_cast<DWORD>(std::min(kChunk, content.m_size - done)), &n, nullptr) ==
			0)
			return fileError(path, "reading the file", lastError());
		if (n == 0) return Error{"\"" + path + "\" became shorter while it was read"};
		done += n;
	}
	return content;
}
}  // namespace ist
