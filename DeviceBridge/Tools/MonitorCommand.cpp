// SPDX-License-Identifier: Zlib
#include <algorithm>
#include <cinttypes>
#include <cstdio>

#include "DeviceBridge/Timing/Clock.h"
#include "DeviceBridge/Tools/Commands.h"
#include "DeviceBridge/Tools/OpenedDevice.h"

namespace devicebridge::tools
{
/// Reads at 1 kHz without sending any force, and prints one CSV line every 1 / rate.
int runMonitor(const RunArguments& arguments)
{
	auto opened = openWithHand(arguments.uri);
	if (!opened) return fail(opened.error().message);
	Device& device = *opened.value();
	VirtualClock virtualClock;
	RealClock realClock;
	Clock& clock = arguments.realTime ? static_cast<Clock&>(realClock) : virtualClock;
	const auto every = std::max<std::int64_t>(1, static_cast<std::int64_t>(1000 / arguments.rate));
	std::printf("time,status,x,y,z,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz,buttons,flags\n");
	const std::int64_t start = clock.now();
	for (std::int64_t i = 0; i < static_cast<std::int64_t>(1000 * arguments.seconds); ++i)
	{
		clock.sleepUntil(start + i * 1'000'000);
		DeviceState s;
		const DeviceStatus status = device.read(clock.now(), s);
		if (i % every != 0) continue;
		const ist::Quaternion q = ist::quaternion(s.X_WH.rotation);
		const ist::Vec3 &p = s.X_WH.translation, &v = s.twist.linear, &w = s.twist.angular;
		std::printf("%.3f,%s,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%" PRIu32 ",%" PRIu32 "\n",
			1e-9 * static_cast<double>(clock.now() - start), describe(status), p.x, p.y, p.z, q.x, q.y, q.z, q.w, v.x, v.y, v.z, w.x, w.y,
			w.z, s.buttons, s.flags);
	}
	device.close();
	return kGood;
}
}  // namespace devicebridge::tools
