// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/WritableFile.h"

#include "BulletISTCollision/Core/Platform/Windows/OpenHandle.h"

#include <algorithm>
#include <string>
#include <vector>

namespace ist
{
namespace
{
HANDLE handleOf(std::intptr_t file) { return reinterpret_cast<HANDLE>(file); }

/// What the name of a file ends with whose place was taken while a program had it mapped.
constexpr const wchar_t* kAside = L"old";

/// What other programs may do with the file at `path`; empty if it has no such list.
std::vector<std::byte> accessList(const std::filesystem::path& path)
{
	DWORD size = 0;
	::GetFileSecurityW(path.c_str(), DACL_SECURITY_INFORMATION, nullptr, 0, &size);
	std::vector<std::byte> list(size);
	if (size == 0 || ::GetFileSecurityW(path.c_str(), DACL_SECURITY_INFORMATION, list.data(), size, &size) == 0) return {};
	return list;
}

/// Whether a file cannot be replaced because a program has it open, which may end at any time.
bool isInUse(DWORD reason)
{
	return reason == ERROR_ACCESS_DENIED || reason == ERROR_SHARING_VIOLATION || reason == ERROR_USER_MAPPED_FILE;
}

/// Puts `created` in the place of `target`.
bool replaces(const std::filesystem::path& created, const std::filesystem::path& target)
{
	constexpr DWORD kHow = MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH;
	constexpr int kTries = 50;
	for (int i = 0; i < kTries; ++i)
	{
		if (::MoveFileExW(created.c_str(), target.c_str(), kHow) != 0) return true;
		if (!isInUse(::GetLastError())) return false;
		::Sleep(static_cast<DWORD>(i / 5));
	}
	// The system does not delete a file that a program has mapped, but renames it.
	const std::wstring aside = created.native() + kAside;
	if (::MoveFileExW(target.c_str(), aside.c_str(), 0) == 0) return false;
	const bool isThere = ::MoveFileExW(created.c_str(), target.c_str(), kHow) != 0;
	const DWORD reason = ::GetLastError();
	if (isThere) ::DeleteFileW(aside.c_str());
	else ::MoveFileExW(aside.c_str(), target.c_str(), 0);
	::SetLastError(reason);
	return isThere;
}

/// Deletes files that were put aside and that no program has mapped any more.
void deleteAside(const std::filesystem::path& folder)
{
	WIN32_FIND_DATAW found{};
	const HANDLE search = ::FindFirstFileW((folder / (std::wstring(L".tmp*") + kAside)).c_str(), &found);
	if (search == INVALID_HANDLE_VALUE) return;
	do ::DeleteFileW((folder / found.cFileName).c_str());
	while (::FindNextFileW(search, &found) != 0);
	::FindClose(search);
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
	deleteAside(target.parent_path());
	std::vector<std::byte> list = accessList(target);
	SECURITY_ATTRIBUTES access{sizeof access, list.empty() ? nullptr : list.data(), FALSE};
	// No two writers share a name, neither threads of a process nor processes. It is short, because the target's may be as long as the
	// system allows.
	const std::wstring stem = (target.parent_path() / (L".tmp" + std::to_wstring(::GetCurrentProcessId()) + L"_")).native();
	for (unsigned i = 0;; ++i)
	{
		const std::wstring name = stem + std::to_wstring(i);
		OpenHandle file(::CreateFileW(name.c_str(), GENERIC_WRITE, 0, &access, CREATE_NEW, FILE_ATTRIBUTE_NORMAL, nullptr));
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
