// SPDX-License-Identifier: Zlib
#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <cstdlib>
#include <string>

namespace devicebridge
{
/// A mock serial line, as PseudoTerminal: a driver that opens path() talks to this end. Under Wine tests/unit/wine_serial_lines.py makes a
/// pseudoterminal for each connection to the port that SERIAL_LINES names, and answers with the name of its serial line.
class WineSerialLine
{
public:
	WineSerialLine()
	{
		const char* port = std::getenv("SERIAL_LINES");
		boost::system::error_code failed;
		if (!port) return;
		m_wire.connect({boost::asio::ip::address_v4::loopback(), static_cast<unsigned short>(std::atoi(port))}, failed);
		if (!failed) boost::asio::read_until(m_wire, boost::asio::dynamic_buffer(m_path), '\n', failed);
		if (!m_path.empty()) m_path.pop_back();
	}
	~WineSerialLine() { pull(); }
	WineSerialLine(const WineSerialLine&) = delete;
	WineSerialLine& operator=(const WineSerialLine&) = delete;

	bool ok() const { return !m_path.empty(); }
	const std::string& path() const { return m_path; }
	void send(const std::string& bytes)
	{
		boost::system::error_code ignored;
		boost::asio::write(m_wire, boost::asio::buffer(bytes), ignored);
	}
	/// The bytes that have come, after a wait of at most `milliseconds` for the first.
	std::string receive(int milliseconds)
	{
		const SOCKET wire = m_wire.native_handle();
		if (wire == INVALID_SOCKET) return {};
		fd_set readable;
		FD_ZERO(&readable);
		FD_SET(wire, &readable);
		timeval patience{0, 1000 * milliseconds};
		if (::select(0, &readable, nullptr, nullptr, &patience) <= 0) return {};
		char bytes[256];
		boost::system::error_code failed;
		const std::size_t n = m_wire.read_some(boost::asio::buffer(bytes), failed);
		return std::string(bytes, failed ? 0 : n);
	}
	/// Unplugs the cable: a driver that has path() open gets a hang-up.
	void pull()
	{
		boost::system::error_code ignored;
		m_wire.close(ignored);
	}

private:
	boost::asio::io_context m_context;
	boost::asio::ip::tcp::socket m_wire{m_context};
	std::string m_path;
};
}  // namespace devicebridge
