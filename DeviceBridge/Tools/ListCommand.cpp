// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/AssumedLimits.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedProfile.h"
#include "DeviceBridge/Tools/Commands.h"

namespace devicebridge::tools
{
namespace
{
Report freedoms(unsigned bits)
{
	static const char* const kNames[] = {"x", "y", "z", "rx", "ry", "rz", "grip", "hand"};
	Report names = Report::list();
	for (unsigned i = 0; i < 8; ++i)
		if (bits >> i & 1U) names.append(kNames[i]);
	return names;
}
}  // namespace

int runList(bool json)
{
	Report report = newReport(), missing = Report::list();
	Report& drivers = report["drivers"] = Report::list();
	for (const DriverReport& driver : DeviceRegistry().drivers())
	{
		Report& row = drivers.append(Report{{"scheme", driver.scheme + ":"}, {"available", driver.missing.empty()}, {"what", driver.what}});
		if (driver.missing.empty()) continue;
		// Sentences make a table too wide to read.
		if (json) row["reason"] = driver.missing;
		else missing.append({{"scheme", driver.scheme + ":"}, {"reason", driver.missing}});
	}
	Report& devices = report["devices"] = Report::list();
	for (const std::string& name : simulatedProfileNames())
	{
		const auto profile = simulatedProfile(name);
		if (!profile) return fail(profile.error().message, kInternal);
		const DeviceInfo& info = profile.value().info;
		devices.append({{"uri", info.uri}, {"maker", info.maker}, {"model", info.model}});
	}
	if (!missing.empty()) report["missing"] = missing;
	print(report, json);
	return kGood;
}

int runInfo(const RunArguments& arguments)
{
	const auto device = DeviceRegistry().open(arguments.uri);
	if (!device) return fail(device.error().message);
	const DeviceInfo& info = device.value()->info();
	Report report = newReport();
	report["uri"] = info.uri;
	report["maker"] = info.maker;
	report["model"] = info.model;
	report["serial"] = info.serial;
	report["sensed"] = freedoms(info.sensed);
	report["actuated"] = freedoms(info.actuated);
	report["handedness"] = info.handedness == Handedness::Left ? "left" : info.handedness == Handedness::Right ? "right" : "either";
	// An unknown value is null instead of zero.
	const auto number = [&](const char* name, double value) {
		if (value > 0) report[name] = value;
		else report[name] = nullptr;
	};
	number("peak_force", info.peakForce), number("continuous_force", info.continuousForce);
	number("peak_torque", info.peakTorque), number("continuous_torque", info.continuousTorque);
	number("max_stiffness", info.maxStiffness), number("max_angular_stiffness", info.maxAngularStiffness);
	number("max_damping", info.maxDamping), number("max_angular_damping", info.maxAngularDamping);
	number("damping", info.damping), number("angular_damping", info.angularDamping);
	number("resolution", info.resolution), number("angular_resolution", info.angularResolution);
	number("workspace_radius", info.workspaceRadius), number("nominal_rate", info.nominalRate);
	report["assumed"] = namesOfAssumed(info.assumed);
	if (info.profile.empty()) report["profile"] = nullptr;
	else report["profile"] = info.profile;
	report["source"] = info.source;
	print(report, arguments.json);
	return kGood;
}
}  // namespace devicebridge::tools
