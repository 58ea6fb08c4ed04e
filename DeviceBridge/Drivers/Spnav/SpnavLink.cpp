// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Spnav/SpnavLink.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "DeviceBridge/Timing/Clock.h"

#include <spnav.h>  // last: it brings the macros of Xlib

namespace devicebridge
{
namespace
{
constexpr int kWait = 2;  // [ms]
// A deflected mouse reports continuously. One that stops reporting without returning to rest is assumed to be at rest.
constexpr std::int64_t kHeld = 200'000'000;  // [ns]
constexpr double kRate = 500;                // rate of the samples, those without an event included [Hz]

std::atomic<bool> taken{false};

/// Path of the socket that libspnav uses.
std::string socketPath()
{
	if (const char* const path = std::getenv("SPNAV_SOCKET")) return path;
	std::ifstream file("/etc/spnavrc");
	for (std::string line; std::getline(file, line);)
		if (line.compare(0, 7, "socket=") == 0) return line.substr(7);
	return "/var/run/spnav.sock";
}

ist::Error noDaemon() { return {"no spacenavd answers at " + socketPath() + "; install spacenavd and start it", false}; }
}  // namespace

std::string spnavMissing()
{
	sockaddr_un address{};
	address.sun_family = AF_UNIX;
	const std::string path = socketPath();
	if (path.size() >= sizeof address.sun_path) return "the path of the socket is too long: " + path;
	std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
	const int probe = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
	const bool there = probe >= 0 && ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
	if (probe >= 0) close(probe);
	return there ? std::string() : noDaemon().message;
}

ist::Result<DeviceInfo> SpnavLink::connect() noexcept
{
	if (taken.exchange(true)) return ist::Error{"libspnav allows one 6-DOF mouse in a program, and one is open already", false};
	m_open = true;
	if (spnav_open() == -1)
	{
		m_open = false;
		taken = false;
		return noDaemon();
	}
	char name[128] = "";
	if (spnav_dev_name(name, sizeof name) < 0) return ist::Error{"spacenavd runs but has no device: is the mouse plugged in?", false};
	spnav_evmask(SPNAV_EVMASK_DEFAULT);
	std::fill_n(m_counts, 6, 0);
	m_buttons = 0;
	m_pose = {};
	m_lastTime = RealClock().now();
	DeviceInfo info;
	info.uri = m_uri;
	info.model = name;
	info.sensed = kTranslation | kRotation;
	info.nominalRate = kRate;
	info.source = "name from spacenavd";
	return info;
}

void SpnavLink::disconnect() noexcept
{
	if (!m_open) return;
	spnav_close();
	m_open = false;
	taken = false;
}

/// Returns false if the daemon or the device is gone.
bool SpnavLink::takeEvents(std::int64_t now) noexcept
{
	char byte = 0;
	if (recv(spnav_fd(), &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0)
	{
		m_complaint = "spacenavd has ended";
		return false;
	}
	spnav_event event;
	while (spnav_poll_event(&event))
	{
		if (event.type == SPNAV_EVENT_MOTION)
		{
			const spnav_event_motion& m = event.motion;
			const int counts[6] = {m.x, m.y, m.z, m.rx, m.ry, m.rz};
			std::copy_n(counts, 6, m_counts);
			m_lastEvent = now;
		}
		if (event.type == SPNAV_EVENT_BUTTON && event.button.bnum >= 0 && event.button.bnum < 32)
		{
			const std::uint32_t bit = 1U << event.button.bnum;
			m_buttons = event.button.press ? m_buttons | bit : m_buttons & ~bit;
		}
		if (event.type == SPNAV_EVENT_DEV && event.dev.op == SPNAV_DEV_RM)
		{
			m_complaint = "the 6-DOF mouse was unplugged";
			return false;
		}
	}
	return true;
}

void SpnavLink::integrate(double dt) noexcept
{
	const ist::Twist twist = twistOf(m_counts, m_rates);
	m_pose.translation += dt * twist.linear;
	const ist::Quaternion turned = ist::quaternionFromRotationVector(dt * twist.angular) * ist::quaternion(m_pose.rotation);
	m_pose.rotation = rotationMatrix(turned);
}

DeviceLink::Event SpnavLink::exchange(const DeviceCommand&, DeviceSample& sample) noexcept
{
	pollfd wire{spnav_fd(), POLLIN, 0};
	poll(&wire, 1, kWait);
	const std::int64_t now = RealClock().now();
	if (wire.revents != 0 && !takeEvents(now)) return Event::Lost;
	if (now - m_lastEvent > kHeld) std::fill_n(m_counts, 6, 0);
	integrate(1e-9 * static_cast<double>(std::min(now - m_lastTime, kHeld)));
	m_lastTime = now;
	sample.state.X_WH = m_pose;
	sample.state.twist = twistOf(m_counts, m_rates);
	sample.state.buttons = m_buttons;
	sample.state.sampledAt = now;
	return Event::Sample;
}
}  // namespace devicebridge
