// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Device/DeviceAddress.h"
#include "DeviceBridge/Device/ThreadedDevice.h"
#include "DeviceBridge/Drivers/BuiltDrivers.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Spnav/SpnavLink.h"

namespace devicebridge
{
namespace
{
ist::Result<std::unique_ptr<Device>> makeSpnav(const std::string& rest)
{
	DeviceAddress address(rest);
	SpnavRates rates;
	const auto speed = address.takeNumber("speed", rates.speed, 0, 10), turn = address.takeNumber("turn", rates.turn, 0, 100);
	if (!speed) return speed.error();
	if (!turn) return turn.error();
	if (!address.leftOver().empty()) return ist::Error{address.leftOver() + "; it knows speed and turn", false};
	if (!address.path().empty()) return ist::Error{"spnav: takes no name; the daemon has one mouse", false};
	rates.speed = speed.value();
	rates.turn = turn.value();
	return std::unique_ptr<Device>(std::make_unique<ThreadedDevice>(std::make_unique<SpnavLink>(rates, "spnav:" + rest)));
}
}  // namespace

void addSpnav(DeviceRegistry& registry)
{
	registry.addScheme("spnav", makeSpnav, "6-DOF mouse through spacenavd, spnav:?speed=M/S&turn=RAD/S", spnavMissing);
}
}  // namespace devicebridge
