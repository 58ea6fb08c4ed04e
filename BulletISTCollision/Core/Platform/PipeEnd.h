// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <system_error>

namespace ist
{
/// One end of a pipe between two processes of this machine. Closed with the object.
class PipeEnd
{
public:
	PipeEnd() = default;
	~PipeEnd() { close(); }
	PipeEnd(const PipeEnd&) = delete;
	PipeEnd& operator=(const PipeEnd&) = delete;

	/// Opens both ends of a new pipe. No process inherits them but by ChildProcess. Returns why it failed.
	static std::error_code open(PipeEnd& receiving, PipeEnd& sending);
	/// The standard output of this process, as bytes.
	void useStandardOutput();
	void close();

	// These return false if the other end is closed, or the pipe fails.
	bool send(const void* data, std::size_t size);
	bool receive(void* data, std::size_t size);
	/// Whether the next receive will not block, because data has arrived or the other end is closed. Waits at most this long.
	bool waits(int milliseconds) const;

private:
	friend class ChildProcess;
	static constexpr std::intptr_t kClosed = -1;
	std::intptr_t m_end = kClosed;
};
}  // namespace ist
