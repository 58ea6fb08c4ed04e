// SPDX-License-Identifier: Zlib
#pragma once

#if defined(_WIN32)
#include "tests/unit/DeviceBridge/Drivers/WineSerialLine.h"

namespace devicebridge
{
using PseudoTerminal = WineSerialLine;
}
#else

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

namespace devicebridge
{
/// A mock serial line: a driver that opens path() talks to this end.
class PseudoTerminal
{
public:
	PseudoTerminal() : m_end(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC))
	{
		if (m_end < 0 || grantpt(m_end) != 0 || unlockpt(m_end) != 0) return;
		char name[128];
		if (ptsname_r(m_end, name, sizeof name) != 0) return;
		m_path = name;
		// This end is kept open, so that a client may come and go.
		m_other = ::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
		termios raw{};
		tcgetattr(m_other, &raw);
		cfmakeraw(&raw);
		tcsetattr(m_other, TCSANOW, &raw);
	}
	~PseudoTerminal() { pull(); }
	PseudoTerminal(const PseudoTerminal&) = delete;
	PseudoTerminal& operator=(const PseudoTerminal&) = delete;

	bool ok() const { return !m_path.empty(); }
	const std::string& path() const { return m_path; }
	void send(const std::string& bytes) { m_lost |= ::write(m_end, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()); }
	/// The bytes that have come, after a wait of at most `milliseconds` for the first.
	std::string receive(int milliseconds)
	{
		pollfd wire{m_end, POLLIN, 0};
		if (poll(&wire, 1, milliseconds) <= 0) return {};
		char bytes[256];
		const ssize_t n = ::read(m_end, bytes, sizeof bytes);
		return n > 0 ? std::string(bytes, static_cast<std::size_t>(n)) : std::string();
	}
	/// Unplugs the cable: a driver that has path() open gets a hang-up.
	void pull()
	{
		for (int* fd : {&m_other, &m_end})
		{
			if (*fd >= 0) ::close(*fd);
			*fd = -1;
		}
	}

private:
	int m_end = -1, m_other = -1;
	std::string m_path;
	bool m_lost = false;
};
}  // namespace devicebridge
#endif
