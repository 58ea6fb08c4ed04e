// SPDX-License-Identifier: Zlib
// Plug-in for a tracker behind a VRPN server, with its buttons and, if it exerts forces, its force device. VRPN is a C++ library, and its
// symbol names depend on the compiler, so this plug-in is built where VRPN's headers are. Interface: vrpn_Tracker.h, vrpn_Button.h,
// vrpn_ForceDevice.h and vrpn_Connection.h of github.com/vrpn/vrpn, 07.36. Source for angular velocities about the axes of the tracker:
// vrpn_Tracker_Filter.C there. W is the tracker's frame. Addresses: vrpn://HOST:PORT/TRACKER, or VRPN's own TRACKER@tcp://HOST:PORT. VRPN
// reports no limits, so they are options.
#include <vrpn_Button.h>
#include <vrpn_Connection.h>
#include <vrpn_ForceDevice.h>
#include <vrpn_Tracker.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "BulletISTCollision/Core/Base/Pose.h"
#include "DeviceBridge/Device/DeviceAddress.h"
#include "DeviceBridge/Plugins/PluginTable.h"

namespace devicebridge::plugin
{
namespace
{
constexpr std::int64_t kPeriod = 500'000;          // [ns]
constexpr std::int64_t kPatience = 2'000'000'000;  // longest wait for the first sample [ns]
constexpr std::int64_t kRateWindow = 200'000'000;  // interval over which reports are counted [ns]
constexpr double kSmoothing = 0.01;                // time constant of a velocity from positions [s]
// Radius of the force field. If the connection breaks silently, the last force does not follow the hand beyond it.
constexpr float kFieldRadius = 0.1F;  // [m]

double seconds(const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); }

/// Returns false if `q` is no rotation: not finite, or of length zero.
bool unit(const vrpn_float64 (&q)[4], ist::Quaternion& out)
{
	const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
	if (!(length > 0) || !std::isfinite(length)) return false;
	out = {q[0] / length, q[1] / length, q[2] / length, q[3] / length};
	return true;
}

/// VRPN's own name for vrpn://HOST:PORT/TRACKER. It uses TCP, because the alternative requires the server to connect back.
std::optional<std::string> vrpnName(const std::string& path)
{
	if (path.find('@') != std::string::npos) return path;
	const auto slash = path.find('/', 2);
	if (path.compare(0, 2, "//") != 0 || slash == 2 || slash == std::string::npos || slash + 1 == path.size()) return std::nullopt;
	return path.substr(slash + 1) + "@tcp://" + path.substr(2, slash - 2);
}

struct VrpnOptions
{
	int sensor = 0;
	double peakForce = 0, stiffness = 0, rate = 0;
};

class VrpnDevice
{
public:
	static constexpr const char* kName = "vrpn";
	static constexpr const char* kDescription = "trackers and force devices behind a VRPN server";

	VrpnDevice(const std::string& name, vrpn_Connection& connection, const VrpnOptions& options);
	~VrpnDevice();
	VrpnDevice(const VrpnDevice&) = delete;
	VrpnDevice& operator=(const VrpnDevice&) = delete;

	static std::string missing() { return {}; }
	static ist::Result<std::unique_ptr<VrpnDevice>> open(const std::string& address, devicebridge_info& info);
	News exchange(const devicebridge_command& command, devicebridge_state& state, std::string& why);

private:
	static void VRPN_CALLBACK onPose(void* self, const vrpn_TRACKERCB report) { static_cast<VrpnDevice*>(self)->take(report); }
	static void VRPN_CALLBACK onVelocity(void* self, const vrpn_TRACKERVELCB report) { static_cast<VrpnDevice*>(self)->take(report); }
	static void VRPN_CALLBACK onButton(void* self, const vrpn_BUTTONCB report)
	{
		static_cast<VrpnDevice*>(self)->press(report.button, report.state != 0);
	}
	static void VRPN_CALLBACK onButtons(void* self, const vrpn_BUTTONSTATESCB report) { static_cast<VrpnDevice*>(self)->take(report); }
	void take(const vrpn_TRACKERCB& report);
	void take(const vrpn_TRACKERVELCB& report);
	void take(const vrpn_BUTTONSTATESCB& report);
	void press(vrpn_int32 button, bool down);
	bool connected() { return m_connection.connected() && m_connection.doing_okay(); }
	void serve();
	void exert(const double (&force)[3]);
	/// Waits for the first sample and counts the samples after it. Returns 0 if there is none.
	double measureRate();

	vrpn_Connection& m_connection;
	vrpn_Tracker_Remote m_tracker;
	vrpn_Button_Remote m_buttons;
	std::unique_ptr<vrpn_ForceDevice_Remote> m_forces;
	int m_sensor;
	ist::Vec3 m_position, m_linear, m_angular;
	ist::Quaternion m_orientation;
	double m_time = 0;  // time of the last sample, on the server's clock [s]
	unsigned m_pressed = 0;
	std::uint64_t m_samples = 0, m_handed = 0;
	bool m_tellsVelocity = false, m_exerts = false;
	RealClock m_clock;
	Pace m_pace{kPeriod};
};

VrpnDevice::VrpnDevice(const std::string& name, vrpn_Connection& connection, const VrpnOptions& options)
	: m_connection(connection),
	  m_tracker(name.c_str(), &connection),
	  m_buttons(name.c_str(), &connection),
	  m_sensor(options.sensor)
{
	if (options.peakForce > 0) m_forces = std::make_unique<vrpn_ForceDevice_Remote>(name.c_str(), &connection);
	m_tracker.shutup = m_buttons.shutup = true;
	if (m_forces) m_forces->shutup = true;
	m_tracker.register_change_handler(this, &VrpnDevice::onPose, m_sensor);
	m_tracker.register_change_handler(this, &VrpnDevice::onVelocity, m_sensor);
	m_buttons.register_change_handler(this, &VrpnDevice::onButton);
	m_buttons.register_states_handler(this, &VrpnDevice::onButtons);
}

VrpnDevice::~VrpnDevice()
{
	exert({0, 0, 0});
	m_connection.mainloop();
	m_tracker.unregister_change_handler(this, &VrpnDevice::onPose, m_sensor);
	m_tracker.unregister_change_handler(this, &VrpnDevice::onVelocity, m_sensor);
	m_buttons.unregister_change_handler(this, &VrpnDevice::onButton);
	m_buttons.unregister_states_handler(this, &VrpnDevice::onButtons);
	m_connection.removeReference();
}

void VrpnDevice::take(const vrpn_TRACKERCB& report)
{
	const ist::Vec3 position{report.pos[0], report.pos[1], report.pos[2]};
	ist::Quaternion q;
	// A value that is not finite would stay in the averages.
	if (!isFinite(position) || !unit(report.quat, q)) return;
	const double now = seconds(report.msg_time), dt = now - m_time;
	if (m_samples > 0 && dt > 0 && !m_tellsVelocity)
	{
		const double share = dt / (kSmoothing + dt);
		const ist::Mat3 turn = rotationMatrix(q) * transpose(rotationMatrix(m_orientation));
		m_linear += share * ((position - m_position) / dt - m_linear);
		m_angular += share * (rotationVector(ist::quaternion(turn)) / dt - m_angular);
	}
	m_position = position;
	m_orientation = q;
	m_time = now;
	++m_samples;
}

void VrpnDevice::take(const vrpn_TRACKERVELCB& report)
{
	const ist::Vec3 linear{report.vel[0], report.vel[1], report.vel[2]};
	ist::Quaternion turn;
	const bool turns = report.vel_quat_dt > 0 && unit(report.vel_quat, turn);
	const ist::Vec3 angular = turns ? rotationVector(turn) / report.vel_quat_dt : ist::Vec3();
	if (!isFinite(linear) || !isFinite(angular)) return;
	m_tellsVelocity = true;
	m_linear = linear;
	m_angular = angular;
}

// Takes the buttons that were pressed before the connection.
void VrpnDevice::take(const vrpn_BUTTONSTATESCB& report)
{
	for (vrpn_int32 i = 0; i < report.num_buttons; ++i) press(i, report.states[i] != 0);
}

void VrpnDevice::press(vrpn_int32 button, bool down)
{
	if (button < 0 || button >= 32) return;
	const unsigned bit = 1U << button;
	m_pressed = down ? m_pressed | bit : m_pressed & ~bit;
}

void VrpnDevice::serve()
{
	timeval atMost{0, 1000};
	m_connection.mainloop(&atMost);
	m_tracker.mainloop();
	m_buttons.mainloop();
	if (m_forces) m_forces->mainloop();
}

void VrpnDevice::exert(const double (&force)[3])
{
	if (!m_forces) return;
	const bool some = force[0] != 0 || force[1] != 0 || force[2] != 0;
	if (!some && m_exerts) m_forces->stopForceField();
	m_exerts = some;
	if (!some) return;
	const auto single = [](double v) { return static_cast<vrpn_float32>(v); };
	m_forces->setFF_Origin(single(m_position.x), single(m_position.y), single(m_position.z));
	m_forces->setFF_Force(single(force[0]), single(force[1]), single(force[2]));
	m_forces->setFF_Jacobian(0, 0, 0, 0, 0, 0, 0, 0, 0);
	m_forces->setFF_Radius(kFieldRadius);
	m_forces->sendForceField();
}

double VrpnDevice::measureRate()
{
	const auto serveUntil = [&](std::int64_t end, auto&& done) {
		while (m_clock.now() < end && !done()) m_pace.wait(), serve();
	};
	serveUntil(m_clock.now() + kPatience, [&] { return m_samples > 0; });
	if (m_samples == 0) return 0;
	const std::uint64_t before = m_samples;
	serveUntil(m_clock.now() + kRateWindow, [] { return false; });
	return std::clamp(1e9 * static_cast<double>(m_samples - before) / static_cast<double>(kRateWindow), 10.0, 1000.0);
}

ist::Result<std::unique_ptr<VrpnDevice>> VrpnDevice::open(const std::string& rest, devicebridge_info& info)
{
	DeviceAddress address(rest);
	const auto sensor = address.takeNumber("sensor", 0, 0, 1000), force = address.takeNumber("peak_force", 0, 0, 100),
			   stiffness = address.takeNumber("stiffness", 0, 0, 1e5), rate = address.takeNumber("rate", 0, 0, 1e4);
	for (const auto* number : {&sensor, &force, &stiffness, &rate})
		if (!*number) return number->error();
	if (!address.leftOver().empty()) return ist::Error{address.leftOver(), false};
	const std::optional<std::string> name = vrpnName(address.path());
	if (!name)
		return ist::Error{"vrpn:" + rest + ": wanted is vrpn://HOST:PORT/TRACKER, for instance vrpn://localhost:3883/Tracker0", false};
	// A separate connection, because only one thread at a time may use a connection of VRPN.
	vrpn_Connection* const connection = vrpn_get_connection_by_name(name->c_str(), nullptr, nullptr, nullptr, nullptr, nullptr, true);
	if (!connection) return ist::Error{"VRPN cannot open a connection to " + *name, false};
	const VrpnOptions options{static_cast<int>(sensor.value()), force.value(), stiffness.value(), rate.value()};
	auto device = std::make_unique<VrpnDevice>(*name, *connection, options);
	const double measured = device->measureRate();
	if (measured == 0 && !device->connected())
		return ist::Error{"no VRPN server answers for " + *name + "; start it, and see that host and port are right", false};
	if (measured == 0)
		return ist::Error{
			"the VRPN server sends no pose of " + *name + ", sensor " + std::to_string(options.sensor) + "; are tracker and sensor right?",
			false};
	info.sensed = DEVICEBRIDGE_TRANSLATION | DEVICEBRIDGE_ROTATION;
	info.actuated = options.peakForce > 0 ? DEVICEBRIDGE_TRANSLATION : 0;
	info.peak_force = options.peakForce, info.max_stiffness = options.stiffness;
	info.nominal_rate = options.rate > 0 ? options.rate : measured;
	setText(info.model, name->substr(0, name->find('@'))), setText(info.maker, "a VRPN server");
	setText(info.source, "VRPN tells no limits: they are given with the address, or unknown; rate: given, or counted");
	return device;
}

News VrpnDevice::exchange(const devicebridge_command& command, devicebridge_state& s, std::string& why)
{
	m_pace.wait();
	exert(command.force);
	serve();
	if (!connected())
	{
		why = "the VRPN server has closed the connection";
		return News::Lost;
	}
	if (m_samples == m_handed) return News::Nothing;
	m_handed = m_samples;
	const ist::Mat3 R = rotationMatrix(m_orientation);
	for (int i = 0; i < 9; ++i) s.rotation[i] = R.m[i / 3][i % 3];
	for (int i = 0; i < 3; ++i) s.position[i] = m_position[i], s.linear[i] = m_linear[i], s.angular[i] = m_angular[i];
	s.velocity_estimated = !m_tellsVelocity;
	s.buttons = m_pressed;
	return News::Sample;
}
}  // namespace
}  // namespace devicebridge::plugin

extern "C" DEVICEBRIDGE_PLUGIN_EXPORT const devicebridge_plugin* devicebridge_plugin_entry(void)
{
	return devicebridge::plugin::tableOf<devicebridge::plugin::VrpnDevice>();
}
