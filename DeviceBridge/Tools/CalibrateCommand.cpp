// SPDX-License-Identifier: Zlib
#include <cstdio>

#include "DeviceBridge/Drivers/Glove/GloveFitting.h"
#include "DeviceBridge/Tools/Commands.h"

namespace devicebridge::tools
{
namespace
{
constexpr std::int64_t kPause = 5'000'000;  // between two looks at the glove [ns]

/// Waits for the Enter key. Returns false at the end of standard input.
bool waitForEnter()
{
	for (int c = std::getchar(); c != '\n'; c = std::getchar())
		if (c == EOF) return false;
	return true;
}
}  // namespace

int runCalibrate(const RunArguments& arguments)
{
	const auto begun = GloveFitting::begin(arguments.uri, arguments.output);
	if (!begun) return fail(begun.error().message);
	GloveFitting& fitting = *begun.value();
	RealClock clock;
	while (fitting.state() == GloveFitting::State::Pose)
	{
		std::fprintf(stderr, "%s; then press Enter\n", fitting.order().c_str());
		if (!waitForEnter()) return fail("standard input ended before the pose was confirmed");
		fitting.confirm();
		while (fitting.update() == GloveFitting::State::Measuring) clock.sleepUntil(clock.now() + kPause);
	}
	if (fitting.state() == GloveFitting::State::Failed) return fail(fitting.complaint());
	Report report = newReport();
	report["sensors"] = fitting.sensors();
	report["file"] = arguments.output;
	report["address"] = fitting.calibratedAddress();
	print(report, arguments.json);
	return kGood;
}
}  // namespace devicebridge::tools
