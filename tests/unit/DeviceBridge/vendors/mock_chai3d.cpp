// SPDX-License-Identifier: Zlib
// A mock of CHAI3D with one omega.7 that the test moves, behind the interface of vendors/chai3d/chai3d.h.
#pragma GCC visibility push(default)
#include "tests/unit/DeviceBridge/vendors/chai3d/chai3d.h"
#pragma GCC visibility pop

#include "tests/unit/DeviceBridge/vendors/MockHandle.h"

namespace
{
MockHandle handle;
using Lock = std::lock_guard<std::mutex>;

bool copy(const double (&from)[3], chai3d::cVector3d& to)
{
	const Lock lock(handle.mutex);
	to = {from[0], from[1], from[2]};
	return handle.present && handle.open;
}
}  // namespace

MOCK_EXPORT MockHandle* mockHandle() { return &handle; }

namespace chai3d
{
void cMatrix3d::identity() { setCol({1, 0, 0}, {0, 1, 0}, {0, 0, 1}); }

cHapticDeviceHandler::cHapticDeviceHandler() : m_numDevices(handle.present) {}
cHapticDeviceHandler::~cHapticDeviceHandler() {}
bool cHapticDeviceHandler::getDevice(cGenericHapticDevicePtr& device, unsigned int index)
{
	device = std::make_shared<cGenericHapticDevice>();
	return index < m_numDevices;
}

bool cGenericHapticDevice::open()
{
	const Lock lock(handle.mutex);
	handle.open += handle.present;
	return handle.present;
}
bool cGenericHapticDevice::close()
{
	const Lock lock(handle.mutex);
	--handle.open;
	return true;
}
bool cGenericHapticDevice::calibrate(bool)
{
	const Lock lock(handle.mutex);
	handle.enabled = 1;
	return handle.present;
}
bool cGenericHapticDevice::getPosition(cVector3d& position) { return copy(handle.position, position); }
bool cGenericHapticDevice::getLinearVelocity(cVector3d& velocity) { return copy(handle.linear, velocity); }
bool cGenericHapticDevice::getAngularVelocity(cVector3d& velocity) { return copy(handle.angular, velocity); }
bool cGenericHapticDevice::getRotation(cMatrix3d& rotation)
{
	double m[3][3];
	const Lock lock(handle.mutex);
	mockRotation(handle.quaternion, m);
	rotation.setCol({m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]}, {m[0][2], m[1][2], m[2][2]});
	return handle.present;
}
bool cGenericHapticDevice::getGripperAngleRad(double& angle)
{
	angle = 0.1;
	return true;
}
bool cGenericHapticDevice::getUserSwitches(unsigned int& switches)
{
	const Lock lock(handle.mutex);
	switches = handle.buttons;
	return handle.present;
}
bool cGenericHapticDevice::setForceAndTorqueAndGripperForce(const cVector3d& force, const cVector3d& torque, const double)
{
	const Lock lock(handle.mutex);
	if (!handle.enabled) ++handle.misuse;
	const double f[3] = {force.x(), force.y(), force.z()}, t[3] = {torque.x(), torque.y(), torque.z()};
	for (int i = 0; i < 3; ++i) handle.force[i] = f[i], handle.torque[i] = t[i];
	return handle.present;
}
cHapticDeviceInfo cGenericHapticDevice::getSpecifications()
{
	return {"omega.7", "Force Dimension", 12, 0.1, 5000, 1, 30, 0.05, 0.075, true, true, true, true, true};
}
}  // namespace chai3d
