// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/WritableFile.h"

#include "BulletISTCollision/Core/Platform/Windows/OpenHandle.h"

#include <algorithm>
#include <string>

namespace ist
{
namespace
{
HANDLE handleOf(std::intptr_t file) { return reinterpret_cast<HANDLE>(file); }

bool isThere(const std::filesystem::path& path) { return ::GetFileAttributesW(path.c_str()) != INVALID_FILE_ATTRIBUTES; }

/// Puts `created` in the place of `target`, which keeps its access list.
bool replaces(const std::filesystem::path& created, const std::filesystem::path& target)
{
	if (!isThere(target)) return ::MoveFileExW(created.c_str(), target.c_str(), MOVEFILE_WRITE_THROUGH) != 0;
	if (::ReplaceFileW(target.c_str(), created.c_str(), nullptr, REPLACEFILE_IGNORE_MERGE_ERRORS, nullptr, nullptr) != 0) return true;
	// The system does not delete a file that a program has mapped, but renames it. It is deleted when it can be.
	const std::wstring aside = created.native() + L"old";
	if (::ReplaceFileW(target.c_str(), created.c_str(), aside.c_str(), REPLACEFILE_IGNORE_MERGE_ERRORS, nullptr, nullptr) != 0)
	{
		::DeleteFileW(aside.c_str());
		return true;
	}
	// File systems that have no access lists.
	return ::MoveFileExW(created.c_str(), target.c_str(), MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH) != 0;
}
}  // namespace

WritableFile::~WritableFile()
{
	(void)close();
	if (!m_created.empty()) ::DeleteFileW(m_created.c_str());
}

std::error_code WritableFile::createBeside(const std::filesystem::path& target)
{
	const DWORD attributes = ::GetFileAttributesW(target.c_str());
	if (attributes != INVALID_FILE_ATTRIBUTES && (attributes & FILE_ATTRIBUTE_READONLY))
		return {ERROR_WRITE_PROTECT, std::system_category()};
	// No two writers share a name, neither threads of a process nor processes. It is short, because the target's may be as long as the
	// system allows.
	const std::wstring stem = (target.parent_path() / (L".tmp" + std::to_wstring(::GetCurrentProcessId()) + L"_")).native();
	for (unsigned i = 0;; ++i)
	{
		const std::wstring name = stem + std::to_wstring(i);
		OpenHandle file(::CreateFileW(name.c_str(), GENERIC_WRITE, 0, nullptr, CREATE_NEW, FILE_ATTRIBUTE_NORMAL, nullptr));
		if (!file.good() && ::GetLastError() == ERROR_FILE_EXISTS) continue;
		if (!file.good()) return lastError();
		m_file = reinterpret_cast<std::intptr_t>(file.release());
		m_target = target;
		m_created = name;
		return {};
	}
}

std::error_code WritableFile::openInPlace(const std::filesystem::path& path)
{
	OpenHandle file(::CreateFileW(path.c_str(), GENERIC_WRITE, FILE_SHARE_READ | FILE_SHARE_WRITE, nullptr, OPEN_EXISTING, 0, nullptr));
	if (!file.good()) return lastError();
	m_file = reinterpret_cast<std::intptr_t>(file.release());
	return {};
}

std::error_code WritableFile::write(const std::byte* bytes, std::size_t size, std::size_t& written)
{
	constexpr std::size_t kMost = std::size_t(1) << 30;
	DWORD n = 0;
	if (::WriteFile(handleOf(m_file), bytes, static_cast<DWORD>(std::min(size, kMost)), &n, nullptr) == 0) return lastError();
	if (n == 0) return {ERROR_DISK_FULL, std::system_category()};
	written = n;
	return {};
}

std::error_code WritableFile::replaceTarget()
{
	if (::FlushFileBuffers(handleOf(m_file)) == 0) return lastError();
	if (const std::error_code failure = close()) return failure;
	if (!replaces(m_created, m_target)) return lastError();
	m_created.clear();
	return {};
}

std::error_code WritableFile::close()
{
	OpenHandle file(handleOf(m_file));
	m_file = -1;
	return file.close() ? std::error_code() : lastError();
}

bool isDeviceOrPipe(const std::filesystem::path& path)
{
	// Names like NUL mean a device in every folder.
	std::wstring full(32768, L'\0');
	const DWORD size = ::GetFullPathNameW(path.c_str(), static_cast<DWORD>(full.size()), full.data(), nullptr);
	return size > 0 && size < full.size() && full.compare(0, 4, L"\\\\.\\") == 0;
}

std::filesystem::path behindLinks(std::filesystem::path path)
{
	const DWORD attributes = ::GetFileAttributesW(path.c_str());
	if (attributes == INVALID_FILE_ATTRIBUTES || !(attributes & FILE_ATTRIBUTE_REPARSE_POINT)) return path;
	const OpenHandle file(::CreateFileW(path.c_str(), 0, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, nullptr, OPEN_EXISTING,
		FILE_FLAG_BACKUP_SEMANTICS, nullptr));
	std::wstring target(32768, L'\0');
	const DWORD size = file.good() ? ::GetFinalPathNameByHandleW(file.get(), target.data(), static_cast<DWORD>(target.size()), 0) : 0;
	if (size == 0 || size >= target.size()) return path;
	target.resize(size);
	return target;
}

std::error_code whyNotWritableInPlace(const std::filesystem::path&) { return {}; }
}  // namespace ist
