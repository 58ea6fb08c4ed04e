// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/PipeEnd.h"

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

#include <algorithm>
#include <utility>

namespace ist
{
namespace
{
constexpr std::size_t kMost = std::size_t(1) << 24;

HANDLE handleOf(std::intptr_t end) { return reinterpret_cast<HANDLE>(end); }
}  // namespace

std::error_code PipeEnd::open(PipeEnd& receiving, PipeEnd& sending)
{
	HANDLE read = nullptr, write = nullptr;
	if (::CreatePipe(&read, &write, nullptr, 1 << 20) == 0) return lastError();
	receiving.m_end = reinterpret_cast<std::intptr_t>(read);
	sending.m_end = reinterpret_cast<std::intptr_t>(write);
	return {};
}

void PipeEnd::useStandardOutput() { m_end = reinterpret_cast<std::intptr_t>(::GetStdHandle(STD_OUTPUT_HANDLE)); }

void PipeEnd::close()
{
	if (m_end != kClosed) ::CloseHandle(handleOf(std::exchange(m_end, kClosed)));
}

bool PipeEnd::send(const void* data, std::size_t size)
{
	for (std::size_t done = 0; done < size;)
	{
		DWORD n = 0;
		const auto most = static_cast<DWORD>(std::min(kMost, size - done));
		if (::WriteFile(handleOf(m_end), static_cast<const char*>(data) + done, most, &n, nullptr) == 0 || n == 0) return false;
		done += n;
	}
	return true;
}

bool PipeEnd::receive(void* data, std::size_t size)
{
	for (std::size_t done = 0; done < size;)
	{
		DWORD n = 0;
		const auto most = static_cast<DWORD>(std::min(kMost, size - done));
		if (::ReadFile(handleOf(m_end), static_cast<char*>(data) + done, most, &n, nullptr) == 0 || n == 0) return false;
		done += n;
	}
	return true;
}

bool PipeEnd::waits(int milliseconds) const
{
	// Pipes without names cannot be waited for.
	const ULONGLONG deadline = ::GetTickCount64() + static_cast<ULONGLONG>(std::max(0, milliseconds));
	for (;;)
	{
		DWORD arrived = 0;
		if (::PeekNamedPipe(handleOf(m_end), nullptr, 0, nullptr, &arrived, nullptr) == 0 || arrived > 0) return true;
		if (::GetTickCount64() >= deadline) return false;
		::Sleep(1);
	}
}
}  // namespace ist
