// SPDX-License-Identifier: Zlib
#pragma once

#include <memory>
#include <string>

#include "DeviceBridge/Device/DeviceLink.h"

namespace devicebridge
{
struct HaplyState;

struct HaplyAddress
{
	std::string host = "localhost", port = "10001";
	std::string device;            ///< id of the device; empty: the first
	std::string grip;              ///< id of the grip; empty: the first that has an orientation
	bool valuesForVector = false;  ///< whether the force vector is named "values", as in services before 3.5
};

/// Whether a program accepts connections at this address.
bool isHaplyListening(const HaplyAddress& address);

/// A device of the Haply Inverse service over WebSocket. The service answers each message with one state, and drops the force if no
/// messages come. It has three forces, a position and, from a VerseGrip, an orientation. W is the basis of the service.
class HaplyLink final : public DeviceLink
{
public:
	HaplyLink(HaplyAddress address, std::string uri);
	~HaplyLink() override;

	ist::Result<DeviceInfo> connect() noexcept override;
	Event exchange(const DeviceCommand& command, DeviceSample& sample) noexcept override;
	void disconnect() noexcept override;
	std::string complaint() const override { return m_complaint; }

private:
	class Socket;
	ist::Result<DeviceInfo> connectOrThrow();
	Event exchangeOrThrow(const DeviceCommand& command, DeviceSample& sample);
	void turn(const HaplyState& heard, std::int64_t now, DeviceState& state);
	Event lost(const std::string& why);

	HaplyAddress m_address;
	std::string m_uri, m_complaint, m_deviceId, m_gripId, m_kind;
	std::unique_ptr<Socket> m_socket;
	bool m_awaiting = false;
	std::int64_t m_lastMessage = 0, m_lastState = 0;  // a message without the device is no state
	std::int64_t m_turnedAt = 0;
	ist::Quaternion m_orientation, m_turned;
	ist::Vec3 m_angular;
};
}  // namespace devicebridge
