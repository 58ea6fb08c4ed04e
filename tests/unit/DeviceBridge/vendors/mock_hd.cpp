// SPDX-License-Identifier: Zlib
// A mock of libHD without devices, with a scheduler thread: one Touch that the test moves. Signatures and constants: hdDevice.h,
// hdScheduler.h and hdDefines.h of HDAPI 3.00 (2004), public in github.com/danepowell/openhaptics, usr/include/HD.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "tests/unit/DeviceBridge/vendors/MockHandle.h"

namespace
{
MockHandle handle;
using Lock = std::lock_guard<std::mutex>;
struct HDErrorInfo
{
	unsigned errorCode;
	int internalErrorCode;
	unsigned hHD;
};
thread_local unsigned pendingError = 0;
std::mutex schedulerMutex;
unsigned (*callback)(void*) = nullptr;
void* userData = nullptr;
std::atomic<bool> running{false};
std::thread scheduler;
bool inFrame = false;

void loop()
{
	while (running)
	{
		{
			const std::lock_guard<std::mutex> lock(schedulerMutex);
			if (callback && callback(userData) == 0) callback = nullptr;
		}
		std::this_thread::sleep_for(std::chrono::milliseconds(1));
	}
}
}  // namespace

MOCK_EXPORT MockHandle* mockHandle() { return &handle; }

MOCK_EXPORT unsigned hdInitDevice(const char* name)
{
	const Lock lock(handle.mutex);
	pendingError = handle.present && (!name || name[0] == 'R') ? 0 : 0x0302;  // HD_COMM_ERROR
	if (pendingError) return 0xFFFFFFFF;
	++handle.open;
	return 0;
}
MOCK_EXPORT void hdMakeCurrentDevice(unsigned) {}
MOCK_EXPORT void hdDisableDevice(unsigned)
{
	const Lock lock(handle.mutex);
	--handle.open;
	if (running) ++handle.misuse;
}
MOCK_EXPORT void hdBeginFrame(unsigned)
{
	const Lock lock(handle.mutex);
	inFrame = true;
}
MOCK_EXPORT void hdEndFrame(unsigned)
{
	const Lock lock(handle.mutex);
	inFrame = false;
	if (!handle.present) pendingError = 0x0302;
	else if (!handle.motorsOn) pendingError = 0x0200;  // HD_WARM_MOTORS
}
MOCK_EXPORT HDErrorInfo hdGetError()
{
	const unsigned code = pendingError;
	pendingError = 0;
	return {code, 0, 0};
}
MOCK_EXPORT const char* hdGetErrorString(unsigned code) { return code == 0x0302 ? "device communication error" : "other error"; }
MOCK_EXPORT void hdEnable(unsigned what)
{
	const Lock lock(handle.mutex);
	handle.enabled = what == 0x4000;
}
MOCK_EXPORT void hdGetIntegerv(unsigned, int* value)
{
	const Lock lock(handle.mutex);
	*value = static_cast<int>(handle.buttons);
}
MOCK_EXPORT void hdGetDoublev(unsigned name, double* value)
{
	const Lock lock(handle.mutex);
	if (name >= 0x2050 && name < 0x2100 && !inFrame) ++handle.misuse;
	switch (name)
	{
	case 0x2052:  // HD_CURRENT_TRANSFORM: column major, millimetres
	{
		double m[3][3];
		mockRotation(handle.quaternion, m);
		for (int i = 0; i < 16; ++i) value[i] = i == 15 ? 1 : 0;
		for (int row = 0; row < 3; ++row)
		{
			for (int column = 0; column < 3; ++column) value[4 * column + row] = m[row][column];
			value[12 + row] = 1000 * handle.position[row];
		}
		break;
	}
	case 0x2051:
		for (int i = 0; i < 3; ++i) value[i] = 1000 * handle.linear[i];
		break;
	case 0x2053: std::copy_n(handle.angular, 3, value); break;
	case 0x2602: *value = 0.5; break;  // HD_NOMINAL_MAX_STIFFNESS [N/mm]
	case 0x2603: *value = 3.3; break;  // HD_NOMINAL_MAX_FORCE [N]
	case 0x2604: *value = 0.88; break;
	case 0x2609: *value = 0.005; break;  // HD_NOMINAL_MAX_DAMPING [N s/mm]
	default: ++handle.misuse;
	}
}
MOCK_EXPORT void hdSetDoublev(unsigned name, const double* value)
{
	const Lock lock(handle.mutex);
	if (name != 0x2700 || !inFrame || !handle.enabled) ++handle.misuse;
	std::copy_n(value, 3, handle.force);
}
MOCK_EXPORT const char* hdGetString(unsigned name) { return name == 0x2501 ? "Touch" : name == 0x2503 ? "3D Systems" : "7"; }
MOCK_EXPORT unsigned hdCheckCalibration()
{
	const Lock lock(handle.mutex);
	return handle.calibrated ? 0x5000 : 0x5001;
}
MOCK_EXPORT void hdStartScheduler()
{
	running = true;
	scheduler = std::thread(loop);
}
MOCK_EXPORT void hdStopScheduler()
{
	running = false;
	scheduler.join();
}
MOCK_EXPORT unsigned long hdScheduleAsynchronous(unsigned (*function)(void*), void* data, unsigned short)
{
	const std::lock_guard<std::mutex> lock(schedulerMutex);
	callback = function, userData = data;
	return 1;
}
MOCK_EXPORT void hdUnschedule(unsigned long)
{
	const std::lock_guard<std::mutex> lock(schedulerMutex);
	callback = nullptr;
}
