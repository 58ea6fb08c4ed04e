// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Device/DeviceAddress.h"
#include "DeviceBridge/Device/ThreadedDevice.h"
#include "DeviceBridge/Drivers/BuiltDrivers.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Glove/GloveLink.h"

namespace devicebridge
{
ist::Result<GloveSettings> gloveSettings(const std::string& rest)
{
	DeviceAddress address(rest);
	GloveSettings settings;
	const std::string hand = address.take("hand").value_or("right"), sensors = address.take("sensors").value_or("0");
	const auto length = address.takeNumber("length", settings.size.length, 0.05, 0.4);
	const auto calibration = address.take("calibration");
	if (hand != "left" && hand != "right") return ist::Error{"The option hand=" + hand + " must be left or right", false};
	if (sensors != "0" && sensors != "18" && sensors != "22")
		return ist::Error{"The option sensors=" + sensors + " must be 18 or 22", false};
	if (!length) return length.error();
	if (!address.leftOver().empty()) return ist::Error{address.leftOver() + "; it knows hand, sensors, length and calibration", false};
	if (address.path().empty()) return ist::Error{"glove: needs the serial line, for instance glove:/dev/ttyUSB0", false};
	if (calibration)
	{
		const auto read = loadGloveCalibration(*calibration);
		if (!read) return read.error();
		settings.calibration = read.value();
		settings.calibrated = true;
	}
	settings.line = address.path();
	settings.sensors = std::stoi(sensors);
	settings.size = {hand == "left", length.value()};
	return settings;
}

namespace
{
ist::Result<std::unique_ptr<Device>> makeGlove(const std::string& rest)
{
	auto settings = gloveSettings(rest);
	if (!settings) return settings.error();
	return std::unique_ptr<Device>(
		std::make_unique<ThreadedDevice>(std::make_unique<GloveLink>(std::move(settings).value(), "glove:" + rest)));
}
}  // namespace

void addGlove(DeviceRegistry& registry)
{
	registry.addScheme("glove", makeGlove, "CyberGlove on a serial line, glove:/dev/ttyUSB0?hand=right&calibration=FILE");
}
}  // namespace devicebridge
