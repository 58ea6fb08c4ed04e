// SPDX-License-Identifier: Zlib
// Plug-in for Haption Virtuose devices through the Virtuose API, loaded at run time. Signatures, constants and the name of the library:
// VirtuoseAPI.h 4.03 and virtuoseAPI.so, public in github.com/gabrielegiudici93/ROS-Virtuose (virtuose/external/VirtuoseAPI). That library
// exports every function that is looked up here. Poses and forces have the meaning in vpVirtuose.cpp of github.com/lagadic/visp. W is the
// base frame. Options: virtuose:HOST?peak_force=N&peak_torque=N. The API reports no limits, so those of the smallest device are used unless
// options give them.
#include "DeviceBridge/Device/DeviceAddress.h"
#include "DeviceBridge/Plugins/PluginTable.h"
#include "DeviceBridge/Plugins/VendorLibrary.h"

#include "BulletISTCollision/Core/Base/Pose.h"

namespace devicebridge::plugin
{
namespace
{
using Context = void*;
constexpr int kImpedance = 3, kIndexWithoutForce = 3, kButtonCount = 3;
constexpr double kNotGiven = -1;
constexpr float kTimeStep = 1e-3F;           // [s]
constexpr std::int64_t kPeriod = 1'000'000;  // [ns]

struct VirtuoseFunctions
{
	Context (*open)(const char*);
	int (*close)(Context);
	int (*setCommandType)(Context, int);
	int (*setIndexing)(Context, int);
	int (*setTimeStep)(Context, float);
	int (*setForceFactor)(Context, float);
	int (*setSpeedFactor)(Context, float);
	int (*setPower)(Context, int);
	int (*getPower)(Context, int*);
	int (*getDeadMan)(Context, int*);
	int (*getEmergencyStop)(Context, int*);
	int (*getButton)(Context, int, int*);
	int (*getPosition)(Context, float*);
	int (*getSpeed)(Context, float*);
	int (*setForce)(Context, float*);
	int (*errorCode)(Context);
	char* (*errorText)(int);
	std::string missing;
};

VirtuoseFunctions loadVirtuose()
{
	VirtuoseFunctions f;
	VendorLibrary library("DEVICEBRIDGE_VIRTUOSE_LIBRARY", {"virtuoseAPI.so", "virtuoseAPI.dll"});
	library.find("virtOpen", f.open), library.find("virtClose", f.close), library.find("virtSetCommandType", f.setCommandType);
	library.find("virtSetIndexingMode", f.setIndexing), library.find("virtSetTimeStep", f.setTimeStep);
	library.find("virtSetForceFactor", f.setForceFactor), library.find("virtSetSpeedFactor", f.setSpeedFactor);
	library.find("virtSetPowerOn", f.setPower), library.find("virtGetPowerOn", f.getPower);
	library.find("virtGetDeadMan", f.getDeadMan), library.find("virtGetEmergencyStop", f.getEmergencyStop);
	library.find("virtGetButton", f.getButton), library.find("virtGetPhysicalPosition", f.getPosition);
	library.find("virtGetPhysicalSpeed", f.getSpeed), library.find("virtSetForce", f.setForce);
	library.find("virtGetErrorCode", f.errorCode), library.find("virtGetErrorMessage", f.errorText);
	f.missing = library.why();
	return f;
}

class VirtuoseDevice
{
public:
	static constexpr const char* kName = "virtuose";
	static constexpr const char* kDescription = "Haption Virtuose devices through the Virtuose API";

	VirtuoseDevice(const VirtuoseFunctions& functions, Context context) : m_f(functions), m_context(context) {}
	~VirtuoseDevice()
	{
		float none[6] = {};
		m_f.setForce(m_context, none);
		m_f.setPower(m_context, 0);
		m_f.close(m_context);
	}

	static std::string missing() { return loadVirtuose().missing; }
	static ist::Result<std::unique_ptr<VirtuoseDevice>> open(const std::string& address, devicebridge_info& info);
	News exchange(const devicebridge_command& command, devicebridge_state& state, std::string& why);

private:
	bool prepare();
	static std::string errorOf(const VirtuoseFunctions& f, Context context)
	{
		const char* const text = f.errorText(f.errorCode(context));
		return text ? text : "unknown error";
	}
	std::string lastError() const { return errorOf(m_f, m_context); }

	VirtuoseFunctions m_f;
	Context m_context;
	Pace m_pace{kPeriod};
};

ist::Result<std::unique_ptr<VirtuoseDevice>> VirtuoseDevice::open(const std::string& rest, devicebridge_info& info)
{
	DeviceAddress address(rest);
	const auto force = address.takeNumber("peak_force", kNotGiven, 0, 100), torque = address.takeNumber("peak_torque", kNotGiven, 0, 20);
	if (!force) return force.error();
	if (!torque) return torque.error();
	if (!address.leftOver().empty()) return ist::Error{address.leftOver(), false};
	const VirtuoseFunctions f = loadVirtuose();
	if (!f.missing.empty()) return ist::Error{f.missing, false};
	const std::string host = address.path().empty() ? "localhost#5000" : address.path();
	const Context context = f.open(host.c_str());
	if (!context) return ist::Error{"the Virtuose API cannot open '" + host + "': " + errorOf(f, nullptr), false};
	auto device = std::make_unique<VirtuoseDevice>(f, context);
	if (!device->prepare()) return ist::Error{"the Virtuose at '" + host + "' cannot be switched on: " + device->lastError(), false};
	info.sensed = info.actuated = DEVICEBRIDGE_TRANSLATION | DEVICEBRIDGE_ROTATION;
	const bool givesForce = force.value() != kNotGiven, givesTorque = torque.value() != kNotGiven;
	info.peak_force = givesForce ? force.value() : 10;
	info.peak_torque = givesTorque ? torque.value() : 0.8;
	info.max_stiffness = 700;
	setText(info.model, "Virtuose"), setText(info.maker, "Haption");
	setText(info.source, "the API does not tell the model; peaks: given, or of the smallest, not verified; max_stiffness: default of HAPI");
	uint32_t assumed = DEVICEBRIDGE_ASSUMED_MAX_STIFFNESS;
	if (!givesForce) assumed |= DEVICEBRIDGE_ASSUMED_PEAK_FORCE;
	if (!givesTorque) assumed |= DEVICEBRIDGE_ASSUMED_PEAK_TORQUE;
	// If peaks were given, the device is another than the smallest.
	setAssumed(info, assumed, givesForce || givesTorque ? "" : "virtuose6d_desktop");
	return device;
}

bool VirtuoseDevice::prepare()
{
	return m_f.setIndexing(m_context, kIndexWithoutForce) == 0 && m_f.setForceFactor(m_context, 1) == 0 &&
		m_f.setSpeedFactor(m_context, 1) == 0 && m_f.setTimeStep(m_context, kTimeStep) == 0 &&
		m_f.setCommandType(m_context, kImpedance) == 0 && m_f.setPower(m_context, 1) == 0;
}

News VirtuoseDevice::exchange(const devicebridge_command& command, devicebridge_state& s, std::string& why)
{
	m_pace.wait();
	float force[6], position[7] = {}, speed[6] = {};
	for (int i = 0; i < 3; ++i)
	{
		force[i] = static_cast<float>(command.force[i]);
		force[3 + i] = static_cast<float>(command.torque[i]);
	}
	int power = 0, deadMan = 0, running = 0;
	if (m_f.setForce(m_context, force) || m_f.getPosition(m_context, position) || m_f.getSpeed(m_context, speed) ||
		m_f.getPower(m_context, &power) || m_f.getDeadMan(m_context, &deadMan) || m_f.getEmergencyStop(m_context, &running))
	{
		why = "the Virtuose is lost: " + lastError();
		return News::Lost;
	}
	s.buttons = 0;
	for (int i = 0; i < kButtonCount; ++i)
	{
		int pressed = 0;
		if (m_f.getButton(m_context, i + 1, &pressed) == 0 && pressed) s.buttons |= 1U << i;
	}
	const ist::Quaternion q{position[3], position[4], position[5], position[6]};
	const double length = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
	const ist::Mat3 rotation = rotationMatrix(ist::Quaternion{q.x / length, q.y / length, q.z / length, q.w / length});
	for (int i = 0; i < 9; ++i) s.rotation[i] = rotation.m[i / 3][i % 3];
	for (int i = 0; i < 3; ++i)
	{
		s.position[i] = position[i];
		s.linear[i] = speed[i];
		s.angular[i] = speed[3 + i];
	}
	if (!power || !running) s.flags &= ~static_cast<unsigned>(DEVICEBRIDGE_FORCES_ENABLED);
	if (!deadMan) s.flags &= ~static_cast<unsigned>(DEVICEBRIDGE_HAND_PRESENT);
	return News::Sample;
}
}  // namespace
}  // namespace devicebridge::plugin

extern "C" DEVICEBRIDGE_PLUGIN_EXPORT const devicebridge_plugin* devicebridge_plugin_entry(void)
{
	return devicebridge::plugin::tableOf<devicebridge::plugin::VirtuoseDevice>();
}
