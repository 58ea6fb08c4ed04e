// SPDX-License-Identifier: Zlib
// A mock of the Virtuose API without a device: one arm that the test moves. Signatures and constants: VirtuoseAPI.h 4.03 (2020),
// github.com/gabrielegiudici93/ROS-Virtuose, virtuose/external/VirtuoseAPI.
#include <cstring>

#include "tests/unit/DeviceBridge/vendors/MockHandle.h"

namespace
{
MockHandle handle;
int command = 0;
using Lock = std::lock_guard<std::mutex>;
int answer() { return handle.present ? 0 : -1; }
int set(int value, int* to)
{
	*to = value;
	return answer();
}
}  // namespace

MOCK_EXPORT MockHandle* mockHandle() { return &handle; }

MOCK_EXPORT void* virtOpen(const char* name)
{
	const Lock lock(handle.mutex);
	if (!handle.present || std::strcmp(name, "arm.local") != 0) return nullptr;
	++handle.open;
	command = 0;
	return &handle;
}
MOCK_EXPORT int virtClose(void*)
{
	const Lock lock(handle.mutex);
	--handle.open;
	return 0;
}
MOCK_EXPORT int virtSetCommandType(void*, int type)
{
	const Lock lock(handle.mutex);
	command = type;
	return answer();
}
MOCK_EXPORT int virtSetIndexingMode(void*, int) { return 0; }
MOCK_EXPORT int virtSetTimeStep(void*, float)
{
	const Lock lock(handle.mutex);
	handle.misuse += command != 0;
	return 0;
}
MOCK_EXPORT int virtSetForceFactor(void*, float) { return 0; }
MOCK_EXPORT int virtSetSpeedFactor(void*, float) { return 0; }
MOCK_EXPORT int virtSetPowerOn(void*, int on)
{
	const Lock lock(handle.mutex);
	handle.enabled = on;
	return 0;
}
MOCK_EXPORT int virtGetPowerOn(void*, int* on)
{
	const Lock lock(handle.mutex);
	return set(handle.enabled && handle.motorsOn, on);
}
MOCK_EXPORT int virtGetDeadMan(void*, int* held)
{
	const Lock lock(handle.mutex);
	return set(handle.handPresent, held);
}
MOCK_EXPORT int virtGetEmergencyStop(void*, int* running)
{
	const Lock lock(handle.mutex);
	return set(1, running);
}
MOCK_EXPORT int virtGetButton(void*, int number, int* pressed)
{
	const Lock lock(handle.mutex);
	return set(handle.buttons >> (number - 1) & 1U, pressed);
}
MOCK_EXPORT int virtGetPhysicalPosition(void*, float* pose)
{
	const Lock lock(handle.mutex);
	for (int i = 0; i < 3; ++i) pose[i] = static_cast<float>(handle.position[i]);
	for (int i = 0; i < 4; ++i) pose[3 + i] = static_cast<float>(handle.quaternion[i]);
	return answer();
}
MOCK_EXPORT int virtGetPhysicalSpeed(void*, float* speed)
{
	const Lock lock(handle.mutex);
	for (int i = 0; i < 3; ++i) speed[i] = static_cast<float>(handle.linear[i]), speed[3 + i] = static_cast<float>(handle.angular[i]);
	return answer();
}
MOCK_EXPORT int virtSetForce(void*, float* force)
{
	const Lock lock(handle.mutex);
	if (command != 3) ++handle.misuse;  // COMMAND_TYPE_IMPEDANCE
	for (int i = 0; i < 3; ++i) handle.force[i] = force[i], handle.torque[i] = force[3 + i];
	return answer();
}
MOCK_EXPORT int virtGetErrorCode(void*) { return 2; }  // VIRT_E_COMMUNICATION_FAILURE
MOCK_EXPORT char* virtGetErrorMessage(int)
{
	static char text[] = "communication failure";
	return text;
}
