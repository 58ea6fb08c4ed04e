// SPDX-License-Identifier: Zlib
#pragma once

#include <nlohmann/json.hpp>

#include <string>

#include "DeviceBridge/Device/Device.h"

namespace devicebridge::tools
{
/// Exit codes: public contract, the same as those of `ist`.
enum Exit
{
	kGood = 0,
	kBadInput = 1,
	kUsage = 2,
	kInternal = 3,
	kInterrupted = 130
};

/// Fields keep the order in which they were set.
using Report = nlohmann::ordered_json;

struct RunArguments
{
	std::string uri, output;
	std::string hand;  ///< file for the motion of the hand; empty: none
	double seconds = 3;
	double stiffness = -1;  ///< of the wall that fills z < 0 [N/m]; negative: half of what the device bears
	double rate = 10;       ///< of the lines of `monitor` [Hz]
	bool realTime = false, json = false;
};

struct ZWidthArguments
{
	std::string uri = "sim:sigma7";
	int delayTicks = 0, steps = 6;
	double most = -1;  ///< largest damping of the wall [N s/m]; negative: twice that of the device
	bool json = false, quantised = false;
};

int runList(bool json);
int runInfo(const RunArguments& arguments);
int runMonitor(const RunArguments& arguments);
int runRecord(const RunArguments& arguments);
int runReplay(const RunArguments& arguments);
int runZWidth(const ZWidthArguments& arguments);
int runCalibrate(const RunArguments& arguments);
int runSelfTest(const RunArguments& arguments);

/// Begins with "schema":1.
Report newReport();
/// One JSON object on a line, or "name: value" lines for people, on stdout.
void print(const Report& report, bool json);
/// Prints the message on stderr and returns the code.
int fail(const std::string& message, int code = kBadInput);
}  // namespace devicebridge::tools
