// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <string_view>
#include <system_error>

#ifndef WIN32_LEAN_AND_MEAN
#define WIN32_LEAN_AND_MEAN
#endif
#ifndef NOMINMAX
#define NOMINMAX
#endif
#include <windows.h>

namespace ist
{
// Windows is called by its functions for UTF-16; everything of ours is UTF-8.

/// Characters that are not valid become U+FFFD.
inline std::wstring wide(std::string_view utf8)
{
	const int size = static_cast<int>(utf8.size());
	std::wstring text(static_cast<size_t>(::MultiByteToWideChar(CP_UTF8, 0, utf8.data(), size, nullptr, 0)), L'\0');
	::MultiByteToWideChar(CP_UTF8, 0, utf8.data(), size, text.data(), static_cast<int>(text.size()));
	return text;
}

inline std::string narrow(std::wstring_view utf16)
{
	const int size = static_cast<int>(utf16.size());
	std::string text(static_cast<size_t>(::WideCharToMultiByte(CP_UTF8, 0, utf16.data(), size, nullptr, 0, nullptr, nullptr)), '\0');
	::WideCharToMultiByte(CP_UTF8, 0, utf16.data(), size, text.data(), static_cast<int>(text.size()), nullptr, nullptr);
	return text;
}

/// The reason why the last call of the system failed.
inline std::error_code lastError() { return {static_cast<int>(::GetLastError()), std::system_category()}; }
}  // namespace ist
