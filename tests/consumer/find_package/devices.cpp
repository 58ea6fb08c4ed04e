// SPDX-License-Identifier: Zlib
// Devices without Bullet: a simulated one, by its address, for a second. The registry knows the drivers of all others, and needs their
// libraries.
#include <DeviceBridge/Drivers/DeviceRegistry.h>

#include <cstdio>

int main()
{
	const devicebridge::DeviceRegistry registry;
	const auto device = registry.open("sim:sigma7");
	if (!device)
	{
		std::fprintf(stderr, "%s\n", device.error().message.c_str());
		return 1;
	}
	devicebridge::DeviceState state;
	for (std::int64_t now = 0; now <= 1'000'000'000; now += 1'000'000)
	{
		if (device.value()->read(now, state) != devicebridge::DeviceStatus::Ok ||
			device.value()->write({}) != devicebridge::DeviceStatus::Ok)
			return 1;
	}
	const ist::Vec3 at = state.X_WH.translation;
	std::printf("%zu kinds of devices; after a second the hand is at (%.3f, %.3f, %.3f) m\n", registry.schemes().size(), at.x, at.y, at.z);
	return state.sampledAt == 1'000'000'000 && ist::isFinite(at) && registry.schemes().size() > 1 ? 0 : 1;
}
