// SPDX-License-Identifier: Zlib
#include <cstdio>

#include "BulletISTCollision/Core/Asset/AtomicFile.h"
#include "DeviceBridge/Device/DeviceAddress.h"
#include "DeviceBridge/Drivers/Glove/GloveLink.h"
#include "DeviceBridge/Tools/Commands.h"

namespace devicebridge::tools
{
namespace
{
constexpr int kFrames = 50;  // number of frames, half a second

/// The values of a pose after the user has pressed Enter.
ist::Result<GloveValues> held(GloveLink& glove, const char* pose)
{
	std::fprintf(stderr, "%s, hold still and press Enter\n", pose);
	for (int c = std::getchar(); c != '\n'; c = std::getchar())
		if (c == EOF) return ist::Error{"standard input ended before the pose was confirmed", false};
	// Frames that came while the hand was moving are dropped.
	auto old = glove.meanValues(kFrames);
	if (!old) return old;
	return glove.meanValues(kFrames);
}

int calibrate(GloveLink& glove, const RunArguments& arguments)
{
	const auto flat = held(glove, "Lay the hand flat on a table, fingers together");
	if (!flat) return fail(flat.error().message);
	const auto fist = held(glove, "Close the fist, the wrist straight");
	if (!fist) return fail(fist.error().message);
	const auto made = calibrateGlove(flat.value(), fist.value(), glove.sensors() == kGloveSensors);
	if (!made) return fail(made.error().message);
	const std::string text = writeGloveCalibration(made.value());
	const auto written = ist::writeFileAtomically(arguments.output, reinterpret_cast<const std::byte*>(text.data()), text.size());
	if (!written) return fail(written.error().message);
	Report report = newReport();
	report["sensors"] = glove.sensors();
	report["file"] = arguments.output;
	print(report, arguments.json);
	return kGood;
}
}  // namespace

int runCalibrate(const RunArguments& arguments)
{
	const std::string scheme = "glove:";
	if (arguments.uri.compare(0, scheme.size(), scheme) != 0)
		return fail("only gloves are calibrated here (glove:/dev/ttyUSB0). For others, " + howToCalibrate(arguments.uri));
	auto settings = gloveSettings(arguments.uri.substr(scheme.size()));
	if (!settings) return fail(settings.error().message);
	GloveLink glove(std::move(settings).value(), arguments.uri);
	const auto found = glove.connect();
	if (!found) return fail(found.error().message);
	return calibrate(glove, arguments);
}
}  // namespace devicebridge::tools
