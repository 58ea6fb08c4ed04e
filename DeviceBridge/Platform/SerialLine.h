// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace devicebridge
{
/// A serial line at 115200 baud, 8N1, without flow control, as raw bytes: /dev/ttyUSB0, COM3.
class SerialLine
{
public:
	SerialLine() = default;
	~SerialLine() { close(); }
	SerialLine(const SerialLine&) = delete;
	SerialLine& operator=(const SerialLine&) = delete;

	/// Returns why the line cannot be used, in a sentence; empty on success.
	std::string open(const std::string& name);
	void close() noexcept;
	bool isOpen() const noexcept { return m_line != kClosed; }

	/// Writes a text without waiting. Returns whether the line took all of it.
	bool write(const char* text) noexcept;
	/// Discards what has arrived.
	void discardInput() noexcept;
	/// Reads what has arrived, and waits for it at most this long [ms]. Returns the number of bytes, 0 if none came, -1 if the line has
	/// hung up.
	int read(std::uint8_t* bytes, std::size_t size, int patience) noexcept;

private:
	static constexpr std::intptr_t kClosed = -1;
	std::intptr_t m_line = kClosed;
};
}  // namespace devicebridge
