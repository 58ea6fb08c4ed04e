// SPDX-License-Identifier: Zlib
// Plug-in for Force Dimension devices (delta, omega, sigma; Falcon) through libdhd, loaded at run time. Signatures and constants: dhdc.h of
// the DHD Haptic SDK 3.7.2, public in github.com/DavidYaonanZhu/sigma7, include/dhdc.h. W is the SDK's frame: x towards the user, z up.
// libdhd reports no limits, so they come from the profile of the type.
#include <charconv>

#include "DeviceBridge/Plugins/PluginTable.h"
#include "DeviceBridge/Plugins/VendorLibrary.h"

namespace devicebridge::plugin
{
namespace
{
constexpr int kStatusReset = 3, kStatusForce = 5, kStatusRoom = 64;
constexpr std::int64_t kPeriod = 500'000;  // [ns]

struct DhdFunctions
{
	int (*count)();
	int (*openId)(char);
	int (*close)(char);
	int (*stop)(char);
	int (*enableForce)(unsigned char, char);
	int (*systemType)(char);
	const char* (*systemName)(char);
	int (*serial)(unsigned short*, char);
	bool (*hasWrist)(char);
	bool (*hasActiveWrist)(char);
	bool (*hasGripper)(char);
	bool (*isLeftHanded)(char);
	int (*status)(int*, char);
	int (*pose)(double*, double*, double*, double (*)[3], char);
	int (*linear)(double*, double*, double*, char);
	int (*angular)(double*, double*, double*, char);
	unsigned (*buttons)(char);
	int (*gripAngle)(double*, char);
	int (*gripVelocity)(double*, char);
	int (*exert)(double, double, double, double, double, double, double, char);
	const char* (*lastError)();
	std::string missing;
};

DhdFunctions loadDhd()
{
	DhdFunctions f;
	VendorLibrary library("DEVICEBRIDGE_DHD_LIBRARY", {"libdhd.so.3", "libdhd.so", "dhd64.dll"});
	library.find("dhdGetDeviceCount", f.count), library.find("dhdOpenID", f.openId), library.find("dhdClose", f.close);
	library.find("dhdStop", f.stop), library.find("dhdEnableForce", f.enableForce);
	library.find("dhdGetSystemType", f.systemType), library.find("dhdGetSystemName", f.systemName);
	library.find("dhdGetSerialNumber", f.serial), library.find("dhdHasWrist", f.hasWrist);
	library.find("dhdHasActiveWrist", f.hasActiveWrist), library.find("dhdHasGripper", f.hasGripper);
	library.find("dhdIsLeftHanded", f.isLeftHanded);
	library.find("dhdGetStatus", f.status), library.find("dhdGetPositionAndOrientationFrame", f.pose);
	library.find("dhdGetLinearVelocity", f.linear), library.find("dhdGetAngularVelocityRad", f.angular);
	library.find("dhdGetButtonMask", f.buttons), library.find("dhdGetGripperAngleRad", f.gripAngle);
	library.find("dhdGetGripperAngularVelocityRad", f.gripVelocity);
	library.find("dhdSetForceAndTorqueAndGripperForce", f.exert), library.find("dhdErrorGetLastStr", f.lastError);
	f.missing = library.why();
	return f;
}

/// The profile in data/devices for a DHD_DEVICE_... type; empty for an unknown type.
const char* profileOf(int type)
{
	switch (type)
	{
	case 33: return "omega3";
	case 34:
	case 36: return "omega6";
	case 35:
	case 37: return "omega7";
	case 60: return "falcon";
	case 63: return "delta3";
	case 104:
	case 105:
	case 106:
	case 107: return "sigma7";
	default: return "";
	}
}

class DhdDevice
{
public:
	static constexpr const char* kName = "dhd";
	static constexpr const char* kDescription = "Force Dimension devices through libdhd";

	DhdDevice(const DhdFunctions& functions, char id) : m_f(functions), m_id(id) {}
	~DhdDevice()
	{
		m_f.exert(0, 0, 0, 0, 0, 0, 0, m_id);
		m_f.stop(m_id);
		m_f.close(m_id);
	}

	static std::string missing() { return loadDhd().missing; }
	static ist::Result<std::unique_ptr<DhdDevice>> open(const std::string& address, devicebridge_info& info);
	News exchange(const devicebridge_command& command, devicebridge_state& state, std::string& why);

private:
	void describe(devicebridge_info& info);

	DhdFunctions m_f;
	char m_id;
	bool m_wrist = false, m_gripper = false;
	Pace m_pace{kPeriod};
};

ist::Result<std::unique_ptr<DhdDevice>> DhdDevice::open(const std::string& address, devicebridge_info& info)
{
	const DhdFunctions f = loadDhd();
	if (!f.missing.empty()) return ist::Error{f.missing, false};
	int index = 0;
	const char* const end = address.data() + address.size();
	const auto [stop, failure] = std::from_chars(address.data(), end, index);
	if (!address.empty() && (failure != std::errc() || stop != end))
		return ist::Error{"dhd:" + address + ": the index must be a number", false};
	const int count = f.count();
	if (index < 0 || index >= count)
		return ist::Error{
			"libdhd finds " + std::to_string(count < 0 ? 0 : count) + " devices, there is no dhd:" + std::to_string(index), false};
	const int id = f.openId(static_cast<char>(index));
	if (id < 0) return ist::Error{"libdhd cannot open device " + std::to_string(index) + ": " + f.lastError(), false};
	auto device = std::make_unique<DhdDevice>(f, static_cast<char>(id));
	device->describe(info);
	if (f.enableForce(1, static_cast<char>(id)) < 0)
		return ist::Error{std::string("libdhd cannot switch the forces on: ") + f.lastError(), false};
	return device;
}

void DhdDevice::describe(devicebridge_info& info)
{
	m_wrist = m_f.hasWrist(m_id), m_gripper = m_f.hasGripper(m_id);
	info.sensed = info.actuated = DEVICEBRIDGE_TRANSLATION;
	if (m_wrist) info.sensed |= DEVICEBRIDGE_ROTATION;
	if (m_wrist) info.handedness = m_f.isLeftHanded(m_id) ? DEVICEBRIDGE_LEFT : DEVICEBRIDGE_RIGHT;
	if (m_gripper) info.sensed |= DEVICEBRIDGE_GRIP;
	if (m_f.hasActiveWrist(m_id)) info.actuated |= DEVICEBRIDGE_ROTATION;
	const char* const name = m_f.systemName(m_id);
	setText(info.model, name ? name : "");
	setText(info.maker, "Force Dimension");
	unsigned short serial = 0;
	if (m_f.serial(&serial, m_id) >= 0) setText(info.serial, std::to_string(serial));
	setText(info.source, "libdhd tells no limits");
	setAssumed(info, 0, profileOf(m_f.systemType(m_id)));
}

News DhdDevice::exchange(const devicebridge_command& command, devicebridge_state& s, std::string& why)
{
	m_pace.wait();
	const double *f = command.force, *t = command.torque;
	double frame[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
	int status[kStatusRoom] = {};
	// Positive values are other events: time guard, motors saturated.
	bool ok = m_f.exert(f[0], f[1], f[2], t[0], t[1], t[2], command.grip_force, m_id) >= 0;
	ok = ok && m_f.pose(&s.position[0], &s.position[1], &s.position[2], frame, m_id) >= 0;
	ok = ok && m_f.linear(&s.linear[0], &s.linear[1], &s.linear[2], m_id) >= 0;
	ok = ok && m_f.status(status, m_id) >= 0;
	if (ok && m_wrist) ok = m_f.angular(&s.angular[0], &s.angular[1], &s.angular[2], m_id) >= 0;
	if (ok && m_gripper) ok = m_f.gripAngle(&s.grip_angle, m_id) >= 0 && m_f.gripVelocity(&s.grip_velocity, m_id) >= 0;
	if (!ok)
	{
		why = std::string("libdhd has lost the device: ") + m_f.lastError();
		return News::Lost;
	}
	for (int i = 0; i < 9; ++i) s.rotation[i] = frame[i / 3][i % 3];
	s.buttons = m_f.buttons(m_id);
	if (!status[kStatusReset]) s.flags &= ~static_cast<unsigned>(DEVICEBRIDGE_CALIBRATED);
	if (!status[kStatusForce]) s.flags &= ~static_cast<unsigned>(DEVICEBRIDGE_FORCES_ENABLED);
	return News::Sample;
}
}  // namespace
}  // namespace devicebridge::plugin

extern "C" DEVICEBRIDGE_PLUGIN_EXPORT const devicebridge_plugin* devicebridge_plugin_entry(void)
{
	return devicebridge::plugin::tableOf<devicebridge::plugin::DhdDevice>();
}
