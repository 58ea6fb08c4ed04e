// SPDX-License-Identifier: Zlib
// Plug-in for every haptic device that CHAI3D finds. CHAI3D is a C++ library without a shared library to load, so this plug-in is built
// where CHAI3D's headers are. Interface: src/devices/CGenericHapticDevice.h and CHapticDeviceHandler.h of github.com/chai3d/chai3d, 3.3.0.
// W is CHAI3D's frame: x towards the user, y to the right, z up.
#include <chai3d.h>

#include <charconv>
#include <utility>

#include "DeviceBridge/Plugins/PluginTable.h"

namespace devicebridge::plugin
{
namespace
{
constexpr std::int64_t kPeriod = 500'000;  // [ns]

void copy(const chai3d::cVector3d& from, double (&to)[3]) { to[0] = from.x(), to[1] = from.y(), to[2] = from.z(); }

class Chai3dDevice
{
public:
	static constexpr const char* kName = "chai3d";
	static constexpr const char* kDescription = "haptic devices through CHAI3D";

	explicit Chai3dDevice(chai3d::cGenericHapticDevicePtr device) : m_device(std::move(device)) {}
	~Chai3dDevice()
	{
		const chai3d::cVector3d none(0, 0, 0);
		m_device->setForceAndTorqueAndGripperForce(none, none, 0);
		m_device->close();
	}

	static std::string missing()
	{
		chai3d::cHapticDeviceHandler handler;
		return handler.getNumDevices() ? std::string() : "CHAI3D finds no device; plug one in, and see that you may use it";
	}
	static ist::Result<std::unique_ptr<Chai3dDevice>> open(const std::string& address, devicebridge_info& info);
	News exchange(const devicebridge_command& command, devicebridge_state& state, std::string& why);

private:
	void describe(devicebridge_info& info);

	chai3d::cGenericHapticDevicePtr m_device;
	bool m_rotates = false, m_grips = false;
	Pace m_pace{kPeriod};
};

ist::Result<std::unique_ptr<Chai3dDevice>> Chai3dDevice::open(const std::string& address, devicebridge_info& info)
{
	int index = 0;
	const char* const end = address.data() + address.size();
	const auto [stop, failure] = std::from_chars(address.data(), end, index);
	if (!address.empty() && (failure != std::errc() || stop != end || index < 0))
		return ist::Error{"chai3d:" + address + ": the index must be a number", false};
	chai3d::cHapticDeviceHandler handler;
	const unsigned count = handler.getNumDevices();
	// Beyond the last index CHAI3D returns a device that never answers.
	chai3d::cGenericHapticDevicePtr found;
	if (static_cast<unsigned>(index) >= count || !handler.getDevice(found, static_cast<unsigned>(index)))
		return ist::Error{"CHAI3D finds " + std::to_string(count) + " devices, there is no chai3d:" + std::to_string(index), false};
	if (!found->open()) return ist::Error{"CHAI3D cannot open device " + std::to_string(index) + "; is another program using it?", false};
	auto device = std::make_unique<Chai3dDevice>(found);
	if (!found->calibrate()) return ist::Error{"CHAI3D cannot calibrate device " + std::to_string(index), false};
	device->describe(info);
	return device;
}

void Chai3dDevice::describe(devicebridge_info& info)
{
	const chai3d::cHapticDeviceInfo s = m_device->getSpecifications();
	m_rotates = s.m_sensedRotation, m_grips = s.m_sensedGripper;
	if (s.m_sensedPosition) info.sensed |= DEVICEBRIDGE_TRANSLATION;
	if (s.m_sensedRotation) info.sensed |= DEVICEBRIDGE_ROTATION;
	if (s.m_sensedGripper) info.sensed |= DEVICEBRIDGE_GRIP;
	if (s.m_actuatedPosition) info.actuated |= DEVICEBRIDGE_TRANSLATION;
	if (s.m_actuatedRotation) info.actuated |= DEVICEBRIDGE_ROTATION;
	info.peak_force = s.m_maxLinearForce, info.peak_torque = s.m_maxAngularTorque;
	info.max_stiffness = s.m_maxLinearStiffness, info.max_angular_stiffness = s.m_maxAngularStiffness;
	info.max_damping = s.m_maxLinearDamping, info.max_angular_damping = s.m_maxAngularDamping;
	info.workspace_radius = s.m_workspaceRadius;
	setText(info.model, s.m_modelName), setText(info.maker, s.m_manufacturerName);
	setText(info.source, "specifications of CHAI3D, which has them in a table of models");
	const std::pair<double, uint32_t> values[] = {{info.peak_force, DEVICEBRIDGE_ASSUMED_PEAK_FORCE},
		{info.peak_torque, DEVICEBRIDGE_ASSUMED_PEAK_TORQUE}, {info.max_stiffness, DEVICEBRIDGE_ASSUMED_MAX_STIFFNESS},
		{info.max_angular_stiffness, DEVICEBRIDGE_ASSUMED_MAX_ANGULAR_STIFFNESS}, {info.max_damping, DEVICEBRIDGE_ASSUMED_MAX_DAMPING},
		{info.max_angular_damping, DEVICEBRIDGE_ASSUMED_MAX_ANGULAR_DAMPING},
		{info.workspace_radius, DEVICEBRIDGE_ASSUMED_WORKSPACE_RADIUS}};
	uint32_t assumed = 0;
	for (const auto& [value, bit] : values)
		if (value > 0) assumed |= bit;
	setAssumed(info, assumed);
}

News Chai3dDevice::exchange(const devicebridge_command& command, devicebridge_state& state, std::string& why)
{
	m_pace.wait();
	const double *f = command.force, *t = command.torque;
	chai3d::cVector3d position, linear, angular;
	chai3d::cMatrix3d rotation;
	rotation.identity();
	bool ok = m_device->setForceAndTorqueAndGripperForce({f[0], f[1], f[2]}, {t[0], t[1], t[2]}, command.grip_force);
	ok = ok && m_device->getPosition(position) && m_device->getLinearVelocity(linear) && m_device->getUserSwitches(state.buttons);
	if (ok && m_rotates) ok = m_device->getRotation(rotation) && m_device->getAngularVelocity(angular);
	if (ok && m_grips) ok = m_device->getGripperAngleRad(state.grip_angle);
	if (!ok)
	{
		why = "CHAI3D has lost the device";
		return News::Lost;
	}
	const chai3d::cVector3d columns[3] = {rotation.getCol0(), rotation.getCol1(), rotation.getCol2()};
	for (int column = 0; column < 3; ++column)
	{
		double v[3];
		copy(columns[column], v);
		for (int row = 0; row < 3; ++row) state.rotation[3 * row + column] = v[row];
	}
	copy(position, state.position);
	copy(linear, state.linear);
	if (m_rotates) copy(angular, state.angular);
	state.velocity_estimated = 1;
	return News::Sample;
}
}  // namespace
}  // namespace devicebridge::plugin

extern "C" DEVICEBRIDGE_PLUGIN_EXPORT const devicebridge_plugin* devicebridge_plugin_entry(void)
{
	return devicebridge::plugin::tableOf<devicebridge::plugin::Chai3dDevice>();
}
