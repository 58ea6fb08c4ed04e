// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Haply/HaplyLink.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include <chrono>
#include <exception>
#include <utility>

#include "DeviceBridge/Drivers/AssumedLimits.h"
#include "DeviceBridge/Drivers/Haply/HaplyMessages.h"
#include "DeviceBridge/Timing/Clock.h"

namespace devicebridge
{
namespace
{
namespace asio = boost::asio;
namespace beast = boost::beast;
using tcp = asio::ip::tcp;
using Failure = boost::system::error_code;

constexpr std::int64_t kConnecting = 3'000'000'000, kSending = 200'000'000, kAnswering = 1'000'000'000;  // [ns]
constexpr std::int64_t kTurnSpan = 5'000'000;  // interval over which the angular velocity is estimated [ns]
}  // namespace

bool isHaplyListening(const HaplyAddress& address)
{
	Failure failure;
	asio::io_context context;
	tcp::resolver resolver(context);
	const auto found = resolver.resolve(address.host, address.port, failure);
	if (failure) return false;
	tcp::socket socket(context);
	asio::connect(socket, found, failure);
	return !failure;
}

/// A connection in which every wait has a limit.
class HaplyLink::Socket
{
public:
	/// Opens the connection. Returns an error message, or an empty string.
	std::string open(const HaplyAddress& address)
	{
		Failure failure;
		tcp::resolver resolver(m_context);
		const auto found = resolver.resolve(address.host, address.port, failure);
		if (failure) return failure.message();
		auto& stream = beast::get_lowest_layer(m_socket);
		if (!finish(
				kConnecting, [&](auto done) { stream.async_connect(found, [done](Failure f, const tcp::endpoint&) { done(f); }); },
				failure))
			return failure.message();
		stream.socket().set_option(tcp::no_delay(true), failure);
		finish(
			kConnecting, [&](auto done) { m_socket.async_handshake(address.host + ":" + address.port, "/", done); }, failure);
		return failure ? failure.message() : std::string();
	}
	/// Returns false if the message was not sent in time.
	bool send(const std::string& text, Failure& failure)
	{
		return finish(
			kSending, [&](auto done) { m_socket.async_write(asio::buffer(text), [done](Failure f, std::size_t) { done(f); }); }, failure);
	}
	/// Waits for a message. Returns whether one has come in time; the next call continues the same wait.
	bool receive(std::int64_t patience, std::string& text, Failure& failure)
	{
		if (!m_reading)
		{
			m_reading = true;
			m_received = false;
			m_readFailure = {};
			m_socket.async_read(m_buffer, [this](Failure f, std::size_t) {
				m_readFailure = f;
				m_received = true;
			});
		}
		runUntil(patience, m_received);
		failure = m_readFailure;
		if (!m_received) return false;
		m_reading = false;
		text = beast::buffers_to_string(m_buffer.data());
		m_buffer.consume(m_buffer.size());
		return !failure;
	}

private:
	/// Starts an operation and waits for its end. An operation that has not ended in time ends with the socket.
	template <class Start> bool finish(std::int64_t patience, const Start& start, Failure& failure)
	{
		const auto ended = std::make_shared<std::pair<bool, Failure>>(false, Failure());
		start([ended](Failure f) { *ended = {true, f}; });
		runUntil(patience, ended->first);
		failure = ended->first ? ended->second : Failure(asio::error::timed_out);
		return !failure;
	}
	void runUntil(std::int64_t patience, const bool& ended)
	{
		const auto deadline = std::chrono::steady_clock::now() + std::chrono::nanoseconds(patience);
		m_context.restart();
		while (!ended && m_context.run_one_until(deadline) > 0)
		{}
	}

	asio::io_context m_context;
	beast::websocket::stream<beast::tcp_stream> m_socket{m_context};
	beast::flat_buffer m_buffer;
	bool m_reading = false, m_received = false;
	Failure m_readFailure;
};

HaplyLink::HaplyLink(HaplyAddress address, std::string uri) : m_address(std::move(address)), m_uri(std::move(uri)), m_gripId(m_address.grip)
{}

HaplyLink::~HaplyLink() { disconnect(); }

ist::Result<DeviceInfo> HaplyLink::connect() noexcept
{
	try
	{
		return connectOrThrow();
	}
	catch (const std::exception& e)
	{
		return ist::Error{std::string("the connection to the Haply Inverse service failed: ") + e.what(), false};
	}
}

ist::Result<DeviceInfo> HaplyLink::connectOrThrow()
{
	const std::string where = m_address.host + ":" + m_address.port;
	m_socket = std::make_unique<Socket>();
	m_awaiting = false;
	const std::string failure = m_socket->open(m_address);
	if (!failure.empty()) return ist::Error{"no Haply Inverse service at " + where + " (" + failure + "); install and start it", false};
	std::string text;
	Failure lost;
	// The first message comes without a request and contains the inventory.
	if (!m_socket->receive(kAnswering, text, lost)) return ist::Error{"what answers at " + where + " is no Haply Inverse service", false};
	const auto read = readHaplyMessage(text, m_address.device, m_gripId);
	if (!read) return ist::Error{where + ": " + read.error().message, false};
	if (!read.value())
		return ist::Error{
			"the Haply Inverse service at " + where + " has no device" + (m_address.device.empty() ? "" : " " + m_address.device), false};
	const HaplyState& state = *read.value();
	m_deviceId = state.deviceId, m_kind = state.kind;
	// After a reconnection, a grip that sleeps keeps its last known orientation.
	if (state.orientation) m_gripId = state.gripId, m_orientation = *state.orientation;
	m_lastMessage = m_lastState = RealClock().now();
	m_turnedAt = 0;
	m_angular = {};
	DeviceInfo info;
	info.uri = m_uri;
	info.maker = "Haply", info.model = state.kind, info.serial = state.deviceId;
	info.actuated = info.sensed = kTranslation;
	if (state.orientation) info.sensed |= kRotation;
	if (profileOfModel(info.maker, info.model).empty())
	{
		// The service reports no limits, and there is no profile for an Inverse3x or a Minverse.
		info.peakForce = 10, info.continuousForce = 4;
		info.assumed |= kAssumedPeakForce | kAssumedContinuousForce;
		info.source = "assumed, of the Inverse3, not verified: peak_force, continuous_force";
	}
	assumeLimits(info);
	return info;
}

DeviceLink::Event HaplyLink::lost(const std::string& why)
{
	m_complaint = why;
	return Event::Lost;
}

DeviceLink::Event HaplyLink::exchange(const DeviceCommand& command, DeviceSample& sample) noexcept
{
	try
	{
		return exchangeOrThrow(command, sample);
	}
	catch (const std::exception& e)
	{
		return lost(std::string("the connection to the Haply Inverse service failed: ") + e.what());
	}
}

DeviceLink::Event HaplyLink::exchangeOrThrow(const DeviceCommand& command, DeviceSample& sample)
{
	Failure failure;
	if (!m_awaiting && !m_socket->send(haplyForceMessage(m_kind, m_deviceId, command.wrench.force, m_address.valuesForVector), failure))
		return lost("the Haply Inverse service does not take commands: " + failure.message());
	m_awaiting = true;
	std::string text;
	if (!m_socket->receive(kLongestWait, text, failure))
	{
		if (failure) return lost("the Haply Inverse service has closed the connection: " + failure.message());
		if (RealClock().now() - m_lastMessage > kAnswering) return lost("the Haply Inverse service does not answer any more");
		return Event::Nothing;
	}
	m_awaiting = false;
	const auto read = readHaplyMessage(text, m_deviceId, m_gripId);
	if (!read) return lost(read.error().message);
	const std::int64_t now = m_lastMessage = RealClock().now();
	// A message without the device is not a sample. One second without the device counts as its loss.
	if (!read.value())
		return now - m_lastState > kAnswering ? lost("the device " + m_deviceId + " has left the Haply Inverse service") : Event::Nothing;
	m_lastState = now;
	const HaplyState& state = *read.value();
	sample.state.X_WH.translation = state.position;
	sample.state.twist.linear = state.velocity;
	sample.state.buttons = state.buttons;
	sample.state.sampledAt = now;
	turn(state, now, sample.state);
	return Event::Sample;
}

/// Sets orientation and angular velocity, because the service gives no angular velocity. A grip that sleeps or is out of range keeps its
/// last orientation. From the first orientation on, the grip stays the same.
void HaplyLink::turn(const HaplyState& heard, std::int64_t now, DeviceState& state)
{
	if (heard.orientation)
	{
		m_gripId = heard.gripId;
		m_orientation = *heard.orientation;
		if (m_turnedAt == 0) m_turnedAt = now, m_turned = m_orientation;
		if (now - m_turnedAt >= kTurnSpan)
		{
			m_angular = (1e9 / static_cast<double>(now - m_turnedAt)) * rotationVector(m_orientation * conjugate(m_turned));
			m_turnedAt = now;
			m_turned = m_orientation;
		}
	}
	else m_turnedAt = 0, m_angular = {};
	state.X_WH.rotation = rotationMatrix(m_orientation);
	state.twist.angular = m_angular;
}

void HaplyLink::disconnect() noexcept
{
	try
	{
		Failure failure;
		if (m_socket && !m_deviceId.empty()) m_socket->send(haplyForceMessage(m_kind, m_deviceId, {}, m_address.valuesForVector), failure);
	}
	catch (const std::exception&)
	{}
	m_socket.reset();
	m_deviceId.clear();
}
}  // namespace devicebridge
