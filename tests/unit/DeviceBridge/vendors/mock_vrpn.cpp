// SPDX-License-Identifier: Zlib
// A mock of VRPN with one server, "lab:3883", whose tracker "Tool0" the test moves, behind the interface of vendors/vrpn.
#pragma GCC visibility push(default)
#include "tests/unit/DeviceBridge/vendors/vrpn/vrpn_Button.h"
#include "tests/unit/DeviceBridge/vendors/vrpn/vrpn_ForceDevice.h"
#include "tests/unit/DeviceBridge/vendors/vrpn/vrpn_Tracker.h"
#pragma GCC visibility pop

#include "tests/unit/DeviceBridge/vendors/MockHandle.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ctime>

namespace
{
MockHandle handle;
using Lock = std::lock_guard<std::mutex>;
constexpr const char* kDevice = "Tool0@tcp://lab:3883";
constexpr int kSensor = 2;

class Connection final : public vrpn_Connection
{
public:
	explicit Connection(bool known) : m_known(known)
	{
		const Lock lock(handle.mutex);
		handle.open += m_known;
	}
	~Connection() override
	{
		const Lock lock(handle.mutex);
		handle.open -= m_known;
	}
	vrpn_bool connected() const override
	{
		const Lock lock(handle.mutex);
		return m_known && handle.present;
	}
	int mainloop(const timeval* wait) override
	{
		const timespec time{0, wait ? 1000 * wait->tv_usec : 0};
		nanosleep(&time, nullptr);
		return 0;
	}

private:
	bool m_known;
};

/// The rotation of an angular velocity `w` in 0.01 s; a server may choose the interval.
void turnOf(const double (&w)[3], vrpn_float64 (&q)[4], vrpn_float64& dt)
{
	const double speed = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
	dt = 0.01;
	for (int i = 0; i < 3; ++i) q[i] = speed > 0 ? w[i] / speed * std::sin(0.5 * speed * dt) : 0;
	q[3] = std::cos(0.5 * speed * dt);
}
}  // namespace

MOCK_EXPORT MockHandle* mockHandle() { return &handle; }

vrpn_Connection::~vrpn_Connection() {}
vrpn_bool vrpn_Connection::doing_okay() const { return true; }
vrpn_bool vrpn_Connection::connected() const { return true; }
void vrpn_Connection::removeReference() { delete this; }

vrpn_Connection* vrpn_get_connection_by_name(const char* name, const char*, const char*, const char*, const char*, const char*, bool)
{
	return new Connection(std::strstr(name, "@tcp://lab:3883") != nullptr);
}

vrpn_Tracker_Remote::vrpn_Tracker_Remote(const char* name, vrpn_Connection*) : m_known(std::strcmp(name, kDevice) == 0) {}
vrpn_Tracker_Remote::~vrpn_Tracker_Remote()
{
	// The client that registered VRPN's callbacks must remove them.
	const Lock lock(handle.mutex);
	if (m_pose || m_velocity) ++handle.misuse;
}
int vrpn_Tracker_Remote::register_change_handler(void* userdata, vrpn_TRACKERCHANGEHANDLER handler, vrpn_int32 sensor)
{
	if (sensor == kSensor) m_userdata = userdata, m_pose = handler;
	return 0;
}
int vrpn_Tracker_Remote::unregister_change_handler(void*, vrpn_TRACKERCHANGEHANDLER handler, vrpn_int32)
{
	if (m_pose == handler) m_pose = nullptr;
	return 0;
}
int vrpn_Tracker_Remote::register_change_handler(void* userdata, vrpn_TRACKERVELCHANGEHANDLER handler, vrpn_int32 sensor)
{
	if (sensor == kSensor) m_userdata = userdata, m_velocity = handler;
	return 0;
}
int vrpn_Tracker_Remote::unregister_change_handler(void*, vrpn_TRACKERVELCHANGEHANDLER handler, vrpn_int32)
{
	if (m_velocity == handler) m_velocity = nullptr;
	return 0;
}
void vrpn_Tracker_Remote::mainloop()
{
	vrpn_TRACKERCB pose{};
	vrpn_TRACKERVELCB velocity{};
	bool tells = false;
	{
		const Lock lock(handle.mutex);
		if (!handle.present || !m_known) return;
		timespec now{};
		clock_gettime(CLOCK_REALTIME, &now);
		pose.msg_time = velocity.msg_time = {
			static_cast<decltype(timeval::tv_sec)>(now.tv_sec), static_cast<decltype(timeval::tv_usec)>(now.tv_nsec / 1000)};
		pose.sensor = velocity.sensor = kSensor;
		tells = handle.tellsVelocity;
		// A tracker that reports no velocity moves with it.
		const double since = tells ? 0 : static_cast<double>(now.tv_sec % 1000) + 1e-9 * static_cast<double>(now.tv_nsec);
		for (int i = 0; i < 3; ++i) pose.pos[i] = handle.position[i] + since * handle.linear[i], velocity.vel[i] = handle.linear[i];
		for (int i = 0; i < 4; ++i) pose.quat[i] = handle.quaternion[i];
		turnOf(handle.angular, velocity.vel_quat, velocity.vel_quat_dt);
	}
	if (m_pose) m_pose(m_userdata, pose);
	if (m_velocity && tells) m_velocity(m_userdata, velocity);
}

vrpn_Button_Remote::vrpn_Button_Remote(const char*, vrpn_Connection*) {}
vrpn_Button_Remote::~vrpn_Button_Remote()
{
	const Lock lock(handle.mutex);
	if (m_handler || m_states) ++handle.misuse;
}
int vrpn_Button_Remote::register_states_handler(void* userdata, vrpn_BUTTONSTATESHANDLER handler)
{
	m_userdata = userdata, m_states = handler;
	return 0;
}
int vrpn_Button_Remote::unregister_states_handler(void*, vrpn_BUTTONSTATESHANDLER)
{
	m_states = nullptr;
	return 0;
}
int vrpn_Button_Remote::register_change_handler(void* userdata, vrpn_BUTTONCHANGEHANDLER handler)
{
	m_userdata = userdata, m_handler = handler;
	return 0;
}
int vrpn_Button_Remote::unregister_change_handler(void*, vrpn_BUTTONCHANGEHANDLER)
{
	m_handler = nullptr;
	return 0;
}
void vrpn_Button_Remote::mainloop()
{
	unsigned now = 0;
	{
		const Lock lock(handle.mutex);
		now = handle.buttons;
	}
	// All states are sent once, as to every new connection, then the changes.
	if (m_states)
	{
		vrpn_BUTTONSTATESCB all{};
		all.num_buttons = 32;
		for (int i = 0; i < 32; ++i) all.states[i] = now >> i & 1U;
		m_states(m_userdata, all);
		m_states = nullptr;
		m_told = now;
	}
	for (int i = 0; i < 32; ++i)
	{
		const unsigned bit = 1U << i;
		if (m_handler && ((now ^ m_told) & bit)) m_handler(m_userdata, {{}, i, (now & bit) != 0});
	}
	m_told = now;
}

vrpn_ForceDevice_Remote::vrpn_ForceDevice_Remote(const char*, vrpn_Connection*) {}
vrpn_ForceDevice_Remote::~vrpn_ForceDevice_Remote() {}
void vrpn_ForceDevice_Remote::mainloop() {}
void vrpn_ForceDevice_Remote::setFF_Origin(vrpn_float32 x, vrpn_float32 y, vrpn_float32 z)
{
	m_origin[0] = x, m_origin[1] = y, m_origin[2] = z;
}
void vrpn_ForceDevice_Remote::setFF_Force(vrpn_float32 x, vrpn_float32 y, vrpn_float32 z)
{
	m_force[0] = x, m_force[1] = y, m_force[2] = z;
}
void vrpn_ForceDevice_Remote::setFF_Radius(vrpn_float32 radius) { m_radius = radius; }
void vrpn_ForceDevice_Remote::setFF_Jacobian(
	vrpn_float32, vrpn_float32, vrpn_float32, vrpn_float32, vrpn_float32, vrpn_float32, vrpn_float32, vrpn_float32, vrpn_float32)
{
	m_hasJacobian = true;
}
void vrpn_ForceDevice_Remote::sendForceField()
{
	const Lock lock(handle.mutex);
	// The field ends at its radius about its origin, and servers begin with a Jacobian of their own.
	if (!m_hasJacobian) ++handle.misuse;
	double way = 0;
	for (int i = 0; i < 3; ++i) way = std::max(way, std::fabs(m_origin[i] - handle.position[i]));
	for (int i = 0; i < 3; ++i) handle.force[i] = way < static_cast<double>(m_radius) ? static_cast<double>(m_force[i]) : 0;
}
void vrpn_ForceDevice_Remote::stopForceField()
{
	const Lock lock(handle.mutex);
	for (double& f : handle.force) f = 0;
}
