// SPDX-License-Identifier: Zlib
// Plug-in for Touch and Phantom devices through OpenHaptics' libHD, loaded at run time. Signatures and constants: hdDevice.h, hdScheduler.h
// and hdDefines.h of HDAPI 3.00, public in github.com/danepowell/openhaptics (usr/include/HD). The order of calls is that of
// github.com/jhu-saw/sawSensablePhantom, components/code/mtsSensableHD.cpp. W is the SDK's frame: x right, y up, z towards the user.
// Lengths are millimetres there and metres here. Only forces are sent, because no public source says how libHD expects the torques of
// six-axis devices.
#include <mutex>

#include "DeviceBridge/Plugins/PluginTable.h"
#include "DeviceBridge/Plugins/VendorLibrary.h"
#include "DeviceBridge/Timing/TripleBuffer.h"

namespace devicebridge::plugin
{
namespace
{
using HdHandle = unsigned;
struct HdError
{
	unsigned code;
	int internal;
	HdHandle handle;
};
constexpr HdHandle kNoHandle = 0xFFFFFFFF;
constexpr unsigned kContinue = 1, kForceOutput = 0x4000, kCalibrationOk = 0x5000;
constexpr unsigned kButtons = 0x2000, kTransform = 0x2052, kVelocity = 0x2051, kAngularVelocity = 0x2053, kForce = 0x2700;
constexpr unsigned kModel = 0x2501, kVendor = 0x2503, kSerial = 0x2504;
constexpr unsigned kMaxStiffness = 0x2602, kMaxForce = 0x2603, kMaxContinuousForce = 0x2604, kMaxDamping = 0x2609;
constexpr unsigned short kPriority = 0xFFFF;
constexpr std::int64_t kLongestWait = 5'000'000, kCommandLife = 20'000'000;  // [ns]

struct HdFunctions
{
	HdHandle (*init)(const char*);
	void (*makeCurrent)(HdHandle);
	void (*disable)(HdHandle);
	void (*beginFrame)(HdHandle);
	void (*endFrame)(HdHandle);
	HdError (*error)();
	const char* (*errorText)(unsigned);
	void (*enable)(unsigned);
	void (*getIntegers)(unsigned, int*);
	void (*getDoubles)(unsigned, double*);
	void (*setDoubles)(unsigned, const double*);
	const char* (*getText)(unsigned);
	unsigned (*checkCalibration)();
	void (*startScheduler)();
	void (*stopScheduler)();
	unsigned long (*schedule)(unsigned (*)(void*), void*, unsigned short);
	void (*unschedule)(unsigned long);
	std::string missing;
};

HdFunctions loadHd()
{
	HdFunctions f;
	VendorLibrary library("DEVICEBRIDGE_HD_LIBRARY", {"libHD.so.3", "libHD.so", "HD.dll"});
	library.find("hdInitDevice", f.init), library.find("hdMakeCurrentDevice", f.makeCurrent), library.find("hdDisableDevice", f.disable);
	library.find("hdBeginFrame", f.beginFrame), library.find("hdEndFrame", f.endFrame), library.find("hdGetError", f.error);
	library.find("hdGetErrorString", f.errorText), library.find("hdEnable", f.enable), library.find("hdGetIntegerv", f.getIntegers);
	library.find("hdGetDoublev", f.getDoubles), library.find("hdSetDoublev", f.setDoubles), library.find("hdGetString", f.getText);
	library.find("hdCheckCalibration", f.checkCalibration), library.find("hdStartScheduler", f.startScheduler);
	library.find("hdStopScheduler", f.stopScheduler), library.find("hdScheduleAsynchronous", f.schedule);
	library.find("hdUnschedule", f.unschedule);
	f.missing = library.why();
	return f;
}

struct Sample
{
	double transform[16] = {}, velocity[3] = {}, angular[3] = {};
	int buttons = 0;
	unsigned error = 0, calibration = 0;
};

struct Push
{
	double force[3] = {};
	std::int64_t until = 0;
};

/// The scheduler of libHD, which all devices share: it runs while any is open.
class Scheduler
{
public:
	static void acquire(const HdFunctions& f)
	{
		const std::lock_guard<std::mutex> lock(s_mutex);
		if (s_users++ == 0) f.startScheduler();
	}
	static void release(const HdFunctions& f)
	{
		const std::lock_guard<std::mutex> lock(s_mutex);
		if (--s_users == 0) f.stopScheduler();
	}

private:
	static inline std::mutex s_mutex;
	static inline int s_users = 0;
};

class HdDevice
{
public:
	static constexpr const char* kName = "hd";
	static constexpr const char* kDescription = "Touch and Phantom devices through OpenHaptics";

	HdDevice(const HdFunctions& functions, HdHandle handle) : m_f(functions), m_handle(handle) {}
	~HdDevice();

	static std::string missing() { return loadHd().missing; }
	static ist::Result<std::unique_ptr<HdDevice>> open(const std::string& address, devicebridge_info& info);
	News exchange(const devicebridge_command& command, devicebridge_state& state, std::string& why);

private:
	void describe(devicebridge_info& info);
	void start();
	void servo() noexcept;

	HdFunctions m_f;
	HdHandle m_handle;
	unsigned long m_callback = 0;
	bool m_started = false;
	RealClock m_clock;
	TripleBuffer<Sample> m_samples;
	TripleBuffer<Push> m_pushes;
};

ist::Result<std::unique_ptr<HdDevice>> HdDevice::open(const std::string& address, devicebridge_info& info)
{
	const HdFunctions f = loadHd();
	if (!f.missing.empty()) return ist::Error{f.missing, false};
	const HdHandle handle = f.init(address.empty() ? nullptr : address.c_str());
	const HdError error = f.error();
	if (handle == kNoHandle || error.code != 0)
	{
		if (handle != kNoHandle) f.disable(handle);
		return ist::Error{"libHD cannot open '" + (address.empty() ? "the default device" : address) + "': " + f.errorText(error.code) +
				"; is it configured, connected and paired?",
			false};
	}
	auto device = std::make_unique<HdDevice>(f, handle);
	device->describe(info);
	f.enable(kForceOutput);
	device->start();
	return device;
}

void HdDevice::describe(devicebridge_info& info)
{
	const auto text = [&](unsigned name) {
		const char* const value = m_f.getText(name);
		return std::string(value ? value : "");
	};
	const auto number = [&](unsigned name) {
		double value = 0;
		m_f.getDoubles(name, &value);
		return value;
	};
	info.sensed = DEVICEBRIDGE_TRANSLATION | DEVICEBRIDGE_ROTATION;
	info.actuated = DEVICEBRIDGE_TRANSLATION;
	setText(info.model, text(kModel)), setText(info.maker, text(kVendor)), setText(info.serial, text(kSerial));
	info.peak_force = number(kMaxForce), info.continuous_force = number(kMaxContinuousForce);
	info.max_stiffness = 1e3 * number(kMaxStiffness), info.max_damping = 1e3 * number(kMaxDamping);
	setText(info.source, "reported by libHD");
}

void HdDevice::start()
{
	m_callback = m_f.schedule(
		[](void* self) -> unsigned {
			static_cast<HdDevice*>(self)->servo();
			return kContinue;
		},
		this, kPriority);
	Scheduler::acquire(m_f);
	m_started = true;
}

HdDevice::~HdDevice()
{
	// Zero force for a few ticks of the servo loop before it ends.
	m_pushes.write({});
	if (m_started)
	{
		m_clock.sleepUntil(m_clock.now() + kLongestWait);
		m_f.unschedule(m_callback);
		Scheduler::release(m_f);
	}
	m_f.disable(m_handle);
}

/// Runs in the thread of libHD's scheduler.
void HdDevice::servo() noexcept
{
	Sample sample;
	m_pushes.fetch();
	const double none[3] = {};
	const bool pushing = m_clock.now() < m_pushes.readable().until;
	m_f.makeCurrent(m_handle);
	m_f.beginFrame(m_handle);
	m_f.getDoubles(kTransform, sample.transform);
	m_f.getDoubles(kVelocity, sample.velocity);
	m_f.getDoubles(kAngularVelocity, sample.angular);
	m_f.getIntegers(kButtons, &sample.buttons);
	sample.calibration = m_f.checkCalibration();
	m_f.setDoubles(kForce, pushing ? m_pushes.readable().force : none);
	m_f.endFrame(m_handle);
	sample.error = m_f.error().code;
	m_samples.write(sample);
}

News HdDevice::exchange(const devicebridge_command& command, devicebridge_state& s, std::string& why)
{
	m_pushes.write({{command.force[0], command.force[1], command.force[2]}, m_clock.now() + kCommandLife});
	const std::int64_t deadline = m_clock.now() + 100 * kLongestWait;
	while (!m_samples.fetch())
	{
		m_clock.sleepUntil(m_clock.now() + 250'000);
		if (m_clock.now() < deadline) continue;
		why = "the scheduler of libHD has stopped";
		return News::Lost;
	}
	const Sample& sample = m_samples.readable();
	// Codes 0x02..: force errors, after which libHD itself withholds the force. Codes from 0x03.. on: the device is lost.
	if (sample.error >= 0x0300)
	{
		why = std::string("libHD has lost the device: ") + m_f.errorText(sample.error);
		return News::Lost;
	}
	for (int row = 0; row < 3; ++row)
	{
		for (int column = 0; column < 3; ++column) s.rotation[3 * row + column] = sample.transform[4 * column + row];
		s.position[row] = 1e-3 * sample.transform[12 + row];
		s.linear[row] = 1e-3 * sample.velocity[row];
		s.angular[row] = sample.angular[row];
	}
	s.buttons = static_cast<unsigned>(sample.buttons);
	if (sample.calibration != kCalibrationOk) s.flags &= ~static_cast<unsigned>(DEVICEBRIDGE_CALIBRATED);
	if (sample.error != 0) s.flags &= ~static_cast<unsigned>(DEVICEBRIDGE_FORCES_ENABLED);
	return News::Sample;
}
}  // namespace
}  // namespace devicebridge::plugin

extern "C" DEVICEBRIDGE_PLUGIN_EXPORT const devicebridge_plugin* devicebridge_plugin_entry(void)
{
	return devicebridge::plugin::tableOf<devicebridge::plugin::HdDevice>();
}
