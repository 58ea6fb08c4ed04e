// SPDX-License-Identifier: Zlib
// A mock of libdhd without devices: one sigma.7 that the test moves. Signatures and return codes: dhdc.h of the DHD Haptic SDK 3.7.2
// (2018), github.com/DavidYaonanZhu/sigma7, include/dhdc.h.
#include <algorithm>

#include "tests/unit/DeviceBridge/vendors/MockHandle.h"

namespace
{
MockHandle handle;
using Lock = std::lock_guard<std::mutex>;
int answer() { return handle.present && handle.open ? 0 : -1; }
int copy3(const double (&from)[3], double* x, double* y, double* z)
{
	const Lock lock(handle.mutex);
	*x = from[0], *y = from[1], *z = from[2];
	return answer();
}
}  // namespace

MOCK_EXPORT MockHandle* mockHandle() { return &handle; }

MOCK_EXPORT int dhdGetDeviceCount()
{
	const Lock lock(handle.mutex);
	return handle.present ? 1 : 0;
}
MOCK_EXPORT int dhdOpenID(char id)
{
	const Lock lock(handle.mutex);
	if (id != 0 || !handle.present) return -1;
	++handle.open;
	return 0;
}
MOCK_EXPORT int dhdClose(char)
{
	const Lock lock(handle.mutex);
	--handle.open;
	return 0;
}
MOCK_EXPORT int dhdStop(char)
{
	const Lock lock(handle.mutex);
	std::fill_n(handle.force, 3, 0), std::fill_n(handle.torque, 3, 0);
	return answer();
}
MOCK_EXPORT int dhdEnableForce(unsigned char on, char)
{
	const Lock lock(handle.mutex);
	handle.enabled = on;
	return answer();
}
MOCK_EXPORT int dhdGetSystemType(char) { return 104; }  // DHD_DEVICE_SIGMA331
MOCK_EXPORT const char* dhdGetSystemName(char) { return "sigma.7"; }
MOCK_EXPORT int dhdGetSerialNumber(unsigned short* serial, char)
{
	*serial = 42;
	return 0;
}
MOCK_EXPORT bool dhdHasWrist(char) { return true; }
MOCK_EXPORT bool dhdHasActiveWrist(char) { return true; }
MOCK_EXPORT bool dhdHasGripper(char) { return true; }
MOCK_EXPORT bool dhdIsLeftHanded(char) { return true; }
MOCK_EXPORT int dhdGetStatus(int status[16], char)
{
	const Lock lock(handle.mutex);
	for (int i = 0; i < 16; ++i) status[i] = 0;
	status[0] = status[1] = status[2] = 1;  // power, connected, started
	status[3] = handle.calibrated;          // DHD_STATUS_RESET
	status[5] = handle.motorsOn;            // DHD_STATUS_FORCE
	return answer();
}
MOCK_EXPORT int dhdGetPositionAndOrientationFrame(double* x, double* y, double* z, double matrix[3][3], char)
{
	double m[3][3];
	{
		const Lock lock(handle.mutex);
		mockRotation(handle.quaternion, m);
	}
	for (int i = 0; i < 9; ++i) matrix[i / 3][i % 3] = m[i / 3][i % 3];
	const int code = copy3(handle.position, x, y, z);
	return code < 0 ? code : 1;  // DHD_TIMEGUARD: not an error
}
MOCK_EXPORT int dhdGetLinearVelocity(double* x, double* y, double* z, char) { return copy3(handle.linear, x, y, z); }
MOCK_EXPORT int dhdGetAngularVelocityRad(double* x, double* y, double* z, char) { return copy3(handle.angular, x, y, z); }
MOCK_EXPORT unsigned dhdGetButtonMask(char)
{
	const Lock lock(handle.mutex);
	return handle.buttons;
}
MOCK_EXPORT int dhdGetGripperAngleRad(double* angle, char)
{
	*angle = 0.25;
	return 0;
}
MOCK_EXPORT int dhdGetGripperAngularVelocityRad(double* velocity, char)
{
	*velocity = 0;
	return 0;
}
MOCK_EXPORT int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty, double tz, double, char)
{
	const Lock lock(handle.mutex);
	if (!handle.enabled) ++handle.misuse;
	handle.force[0] = fx, handle.force[1] = fy, handle.force[2] = fz;
	handle.torque[0] = tx, handle.torque[1] = ty, handle.torque[2] = tz;
	return handle.present ? 2 : -1;  // DHD_MOTOR_SATURATED: not an error
}
MOCK_EXPORT const char* dhdErrorGetLastStr() { return "communication error"; }
