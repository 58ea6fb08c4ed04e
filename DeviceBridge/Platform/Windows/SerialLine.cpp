// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Platform/SerialLine.h"

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace devicebridge
{
namespace
{
HANDLE handleOf(std::intptr_t line) { return reinterpret_cast<HANDLE>(line); }

bool configure(HANDLE line) noexcept
{
	DCB settings{};
	settings.DCBlength = sizeof settings;
	if (::GetCommState(line, &settings) == 0) return false;
	settings.BaudRate = CBR_115200;
	settings.ByteSize = 8;
	settings.Parity = NOPARITY;
	settings.StopBits = ONESTOPBIT;
	settings.fBinary = TRUE;
	settings.fParity = settings.fOutxCtsFlow = settings.fOutxDsrFlow = settings.fDsrSensitivity = FALSE;
	settings.fOutX = settings.fInX = settings.fErrorChar = settings.fNull = settings.fAbortOnError = FALSE;
	settings.fDtrControl = DTR_CONTROL_ENABLE;
	settings.fRtsControl = RTS_CONTROL_ENABLE;
	return ::SetCommState(line, &settings) != 0;
}

/// Time limits of reading: at once with what has arrived, or after `patience` [ms].
bool setPatience(HANDLE line, int patience) noexcept
{
	COMMTIMEOUTS limits{};
	limits.ReadIntervalTimeout = MAXDWORD;
	limits.ReadTotalTimeoutMultiplier = patience > 0 ? MAXDWORD : 0;
	limits.ReadTotalTimeoutConstant = static_cast<DWORD>(std::max(0, patience));
	limits.WriteTotalTimeoutConstant = 100;
	return ::SetCommTimeouts(line, &limits) != 0;
}
}  // namespace

std::string SerialLine::open(const std::string& name)
{
	close();
	// From COM10 on, the system wants the longer name.
	const std::string path = name.find('\\') == name.npos && name.find('/') == name.npos ? "\\\\.\\" + name : name;
	const HANDLE line = ::CreateFileW(ist::wide(path).c_str(), GENERIC_READ | GENERIC_WRITE, 0, nullptr, OPEN_EXISTING, 0, nullptr);
	if (line == INVALID_HANDLE_VALUE) return "cannot open the serial line " + name + ": " + ist::lastError().message();
	m_line = reinterpret_cast<std::intptr_t>(line);
	if (configure(line) && setPatience(line, 0)) return {};
	close();
	return name + " is no serial line";
}

void SerialLine::close() noexcept
{
	if (isOpen()) ::CloseHandle(handleOf(std::exchange(m_line, kClosed)));
}

bool SerialLine::write(const char* text) noexcept
{
	const auto size = static_cast<DWORD>(std::strlen(text));
	DWORD written = 0;
	return ::WriteFile(handleOf(m_line), text, size, &written, nullptr) != 0 && written == size;
}

void SerialLine::discardInput() noexcept { ::PurgeComm(handleOf(m_line), PURGE_RXCLEAR); }

int SerialLine::read(std::uint8_t* bytes, std::size_t size, int patience) noexcept
{
	const HANDLE line = handleOf(m_line);
	if (!setPatience(line, patience)) return -1;
	const ULONGLONG end = ::GetTickCount64() + static_cast<ULONGLONG>(std::max(0, patience));
	while (true)
	{
		DWORD n = 0, errors = 0;
		if (::ReadFile(line, bytes, static_cast<DWORD>(size), &n, nullptr) == 0) return -1;
		if (n > 0) return static_cast<int>(n);
		// A read does not tell under every driver that the adapter is gone (Wine's); asking for the line's state does.
		if (::ClearCommError(line, &errors, nullptr) == 0) return -1;
		// Wine returns before the limit of time.
		if (::GetTickCount64() >= end) return 0;
		::Sleep(1);
	}
}
}  // namespace devicebridge
