// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/PipeEnd.h"

#include <cerrno>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

namespace ist
{
namespace
{
/// Calls until all bytes are through. Both read() and write() return 0 or less when no more will come.
template <class Call> bool transfer(std::size_t size, const Call& call)
{
	for (std::size_t done = 0; done < size;)
	{
		const ssize_t n = call(done);
		if (n > 0) done += static_cast<std::size_t>(n);
		else if (n == 0 || errno != EINTR) return false;
	}
	return true;
}
}  // namespace

std::error_code PipeEnd::open(PipeEnd& receiving, PipeEnd& sending)
{
	int ends[2];
	if (::pipe2(ends, O_CLOEXEC) != 0) return {errno, std::generic_category()};
#ifdef F_SETPIPE_SZ
	(void)::fcntl(ends[1], F_SETPIPE_SZ, 1 << 20);
#endif
	receiving.m_end = ends[0];
	sending.m_end = ends[1];
	return {};
}

void PipeEnd::useStandardOutput() { m_end = STDOUT_FILENO; }

void PipeEnd::close()
{
	if (m_end != kClosed) ::close(static_cast<int>(std::exchange(m_end, kClosed)));
}

bool PipeEnd::send(const void* data, std::size_t size)
{
	return transfer(
		size, [&](std::size_t done) { return ::write(static_cast<int>(m_end), static_cast<const char*>(data) + done, size - done); });
}

bool PipeEnd::receive(void* data, std::size_t size)
{
	return transfer(size, [&](std::size_t done) { return ::read(static_cast<int>(m_end), static_cast<char*>(data) + done, size - done); });
}

bool PipeEnd::waits(int milliseconds) const
{
	pollfd asked{static_cast<int>(m_end), POLLIN, 0};
	return ::poll(&asked, 1, milliseconds) > 0;
}
}  // namespace ist
