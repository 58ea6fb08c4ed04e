// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Platform/SerialLine.h"

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace devicebridge
{
namespace
{
bool configure(int line) noexcept
{
	termios settings{};
	if (tcgetattr(line, &settings) != 0) return false;
	cfmakeraw(&settings);
	settings.c_cflag |= CLOCAL | CREAD;
	cfsetspeed(&settings, B115200);
	return tcsetattr(line, TCSANOW, &settings) == 0;
}
}  // namespace

std::string SerialLine::open(const std::string& name)
{
	close();
	const int line = ::open(name.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
	if (line < 0) return "cannot open the serial line " + name + ": " + std::strerror(errno);
	m_line = line;
	if (configure(line)) return {};
	close();
	return name + " is no serial line";
}

void SerialLine::close() noexcept
{
	if (isOpen()) ::close(static_cast<int>(std::exchange(m_line, kClosed)));
}

bool SerialLine::write(const char* text) noexcept
{
	const auto size = static_cast<ssize_t>(std::strlen(text));
	return ::write(static_cast<int>(m_line), text, static_cast<std::size_t>(size)) == size;
}

void SerialLine::discardInput() noexcept { tcflush(static_cast<int>(m_line), TCIFLUSH); }

int SerialLine::read(std::uint8_t* bytes, std::size_t size, int patience) noexcept
{
	pollfd wire{static_cast<int>(m_line), POLLIN, 0};
	poll(&wire, 1, patience);
	if (wire.revents == 0) return 0;
	const ssize_t n = ::read(static_cast<int>(m_line), bytes, size);
	if (n > 0) return static_cast<int>(n);
	return n < 0 && (errno == EAGAIN || errno == EINTR) ? 0 : -1;
}
}  // namespace devicebridge
