// SPDX-License-Identifier: Zlib
#pragma once

#include <cerrno>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

namespace ist
{
/// The reason why the last call of the system failed.
inline std::error_code lastError() { return {errno, std::generic_category()}; }

/// A file descriptor, which is closed with this object.
class OpenFile
{
public:
	explicit OpenFile(int number = -1) : m_file(number) {}
	OpenFile(const std::string& path, int flags, unsigned mode = 0666) : m_file(::open(path.c_str(), flags | O_CLOEXEC, mode)) {}
	~OpenFile() { close(); }
	OpenFile(const OpenFile&) = delete;
	OpenFile& operator=(const OpenFile&) = delete;

	bool good() const { return m_file >= 0; }
	int number() const { return m_file; }
	/// Some systems report a full disk only when the file is closed.
	bool close()
	{
		const int file = release();
		return file < 0 || ::close(file) == 0;
	}
	/// Passes the descriptor on; it is no longer closed.
	int release()
	{
		const int file = m_file;
		m_file = -1;
		return file;
	}

private:
	int m_file;
};
}  // namespace ist
