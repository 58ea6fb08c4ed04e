// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Tools/OpenedDevice.h"

#include <cmath>

#include "DeviceBridge/Decorators/DeviceDecorator.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"

namespace devicebridge::tools
{
namespace
{
constexpr double kRound = 3;  // [s]

HandScript pressingHand()
{
	const ist::Mat3 turned = rotationMatrix(ist::quaternionFromRotationVector(ist::Vec3{0, 0, 0.4}));
	const HandScript once = handThrough({{0, {{}, {0, 0, 0.02}}}, {0.6, {{}, {0, 0, 0.02}}}, {1, {{}, {0, 0, -0.01}}},
		{1.8, {{}, {0.02, 0.01, -0.01}}}, {2.3, {turned, {0.02, 0.01, -0.01}}}, {2.7, {{}, {0, 0, 0.02}}}});
	return [once](double t) { return once(std::fmod(t, kRound)); };
}
}  // namespace

ist::Result<std::unique_ptr<Device>> openWithHand(const std::string& uri)
{
	auto device = DeviceRegistry().open(uri);
	if (!device) return device;
	Device* innermost = device.value().get();
	while (auto* decorator = dynamic_cast<DeviceDecorator*>(innermost)) innermost = &decorator->inner();
	if (auto* simulated = dynamic_cast<SimulatedDevice*>(innermost))
	{
		simulated->place({{}, {0, 0, 0.02}});
		simulated->setHand(pressingHand());
	}
	return device;
}

double wallStiffness(const DeviceInfo& info, double wanted) { return wanted < 0 ? info.maxStiffness / 2 : wanted; }
}  // namespace devicebridge::tools
