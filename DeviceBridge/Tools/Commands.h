// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

#include "BulletISTCollision/Json/JsonValue.h"
#include "DeviceBridge/Device/Device.h"

namespace devicebridge::tools
{
/// Exit codes: a public contract, the same as those of `ist`.
enum Exit
{
	kGood = 0,
	kBadInput = 1,
	kUsage = 2,
	kInternal = 3,
	kInterrupted = 130
};

/// Object whose fields keep the order in which they were set.
using Report = ist::JsonValue;

struct RunArguments
{
	std::string uri, output;
	std::string hand;  ///< file for the motion of the hand; empty: none
	double seconds = 3;
	double stiffness = -1;  ///< stiffness of the wall that fills z < 0 [N/m]; negative: half of what the device bears
	double rate = 10;       ///< rate of the lines of `monitor` [Hz]
	bool realTime = false, json = false;
	bool withoutForces = false;  ///< `acceptance` leaves out the parts that need forces
};

struct ZWidthArguments
{
	std::string uri = "sim:sigma7";
	int delayTicks = 0, steps = 6;
	double most = -1;  ///< largest damping of the wall [N s/m]; negative: twice that of the device
	bool json = false, quantised = false;
};

struct StateArguments
{
	std::vector<std::string> uris;
	double seconds = 0;  ///< 0: half a second, or an hour of `watch`
	bool watch = false, json = false;
};

int runList(bool json);
int runState(const StateArguments& arguments);
int runInfo(const RunArguments& arguments);
int runMonitor(const RunArguments& arguments);
int runRecord(const RunArguments& arguments);
int runReplay(const RunArguments& arguments);
int runZWidth(const ZWidthArguments& arguments);
int runCalibrate(const RunArguments& arguments);
int runSelfTest(const RunArguments& arguments);
int runAcceptance(const RunArguments& arguments);

/// A report that begins with "schema":1.
Report newReport();
/// Prints to stdout, as one JSON object on a line or as a table for people, with units.
void print(const Report& report, bool json);
/// Prints the message to stderr and returns the code.
int fail(const std::string& message, int code = kBadInput);
}  // namespace devicebridge::tools
