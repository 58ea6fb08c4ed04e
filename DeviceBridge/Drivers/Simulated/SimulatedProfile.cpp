// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Simulated/SimulatedProfile.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>

#include "BulletISTCollision/Core/Platform/Utf8Path.h"
#include "BulletISTCollision/Json/JsonValue.h"
#include "DeviceBridge/Drivers/Simulated/CarriedProfiles.h"

namespace devicebridge
{
namespace
{
using Json = ist::JsonValue;

constexpr double kLargest = 1e6;  // largest value of any parameter, in SI units

std::string where(const std::string& text, const std::string& field)
{
	const std::size_t at = text.find("\"" + field + "\"");
	const std::string line = at == std::string::npos ? "" : "line " + std::to_string(ist::lineAt(text, at)) + ", ";
	return line + "field " + field + ": ";
}

std::map<std::string, double*> numbersOf(SimulatedProfile& p)
{
	DeviceInfo& i = p.info;
	return {{"peakForce", &i.peakForce}, {"continuousForce", &i.continuousForce}, {"peakTorque", &i.peakTorque},
		{"continuousTorque", &i.continuousTorque}, {"maxStiffness", &i.maxStiffness}, {"maxAngularStiffness", &i.maxAngularStiffness},
		{"maxDamping", &i.maxDamping}, {"maxAngularDamping", &i.maxAngularDamping}, {"resolution", &i.resolution},
		{"angularResolution", &i.angularResolution}, {"workspaceRadius", &i.workspaceRadius}, {"nominalRate", &i.nominalRate},
		{"mass", &p.mass}, {"inertia", &p.inertia}, {"damping", &p.damping}, {"angularDamping", &p.angularDamping},
		{"handStiffness", &p.handStiffness}, {"handAngularStiffness", &p.handAngularStiffness}, {"handDamping", &p.handDamping},
		{"handAngularDamping", &p.handAngularDamping}};
}

/// What is wrong with one number and its source; empty if both are valid.
std::string takeNumber(const std::string& name, const Json& entry, double& target, DeviceInfo& info)
{
	if (!entry.isObject() || entry.size() != 2 || !entry.contains("value") || !entry.contains("source"))
		return "wants {\"value\": number, \"source\": text}";
	const Json &value = entry["value"], &source = entry["source"];
	if (!value.isNumber()) return "its value is not a number";
	const double number = value.number();
	if (!(number >= 0) || number > kLargest) return "its value must lie from 0 to 1e6, in SI units";
	if (number == 0 && (name == "mass" || name == "inertia" || name == "nominalRate")) return "its value must be above zero";
	if (source.text().empty()) return "it names no source";
	target = number;
	info.source += (info.source.empty() ? "" : "; ") + name + ": " + source.text();
	return {};
}

std::string takeFreedoms(const Json& entry, unsigned& target)
{
	const std::map<std::string, unsigned> known = {
		{"translation", kTranslation}, {"rotation", kRotation}, {"grip", kGrip}, {"x", 1}, {"y", 2}, {"z", 4}};
	if (!entry.isList()) return "wants a list of translation, rotation, grip, x, y, z";
	target = 0;
	for (const Json& item : entry)
	{
		const auto found = known.find(item.text());
		if (found == known.end()) return item.dump() + " is none of translation, rotation, grip, x, y, z";
		target |= found->second;
	}
	return {};
}

std::string takeField(const std::string& name, const Json& entry, SimulatedProfile& profile)
{
	DeviceInfo& info = profile.info;
	if (name == "schema") return entry == 1 ? "" : "this library reads schema 1";
	if (name == "sensed") return takeFreedoms(entry, info.sensed);
	if (name == "actuated") return takeFreedoms(entry, info.actuated);
	if (name == "model" || name == "maker")
	{
		if (entry.text().empty()) return "wants a text";
		(name == "model" ? info.model : info.maker) = entry.text();
		return {};
	}
	const auto numbers = numbersOf(profile);
	const auto found = numbers.find(name);
	return found == numbers.end() ? "no such field is known" : takeNumber(name, entry, *found->second, info);
}

bool endsWith(const std::string& text, const std::string& end)
{
	return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

ist::Result<SimulatedProfile> profileFromFile(const std::string& path)
{
	std::ifstream file(ist::systemPath(path), std::ios::binary);
	if (!file) return ist::Error{"Cannot read the device profile " + path, false};
	const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
	auto profile = parseSimulatedProfile(text);
	if (!profile) return ist::Error{path + ", " + profile.error().message, false};
	return profile;
}
}  // namespace

ist::Result<SimulatedProfile> parseSimulatedProfile(const std::string& text)
{
	const ist::ParsedJson parsed = ist::parseJson(text);
	if (!parsed.ok()) return ist::Error{"line " + std::to_string(parsed.line) + ": not JSON: " + parsed.problem, false};
	if (!parsed.value.isObject()) return ist::Error{"line 1: a profile is one JSON object", false};
	if (!parsed.repeated.empty()) return ist::Error{where(text, parsed.repeated) + "stands there twice", false};
	SimulatedProfile profile;
	for (const auto& [name, entry] : parsed.value.fields())
	{
		const std::string problem = takeField(name, entry, profile);
		if (!problem.empty()) return ist::Error{where(text, name) + problem, false};
	}
	for (const char* wanted : {"schema", "model", "maker", "sensed", "actuated", "peakForce", "damping"})
		if (!parsed.value.contains(wanted)) return ist::Error{where(text, wanted) + "is missing", false};
	profile.info.damping = profile.damping;
	profile.info.angularDamping = profile.angularDamping;
	return profile;
}

std::vector<std::string> simulatedProfileNames()
{
	std::vector<std::string> names;
	for (std::size_t i = 0; i < kCarriedProfileCount; ++i) names.push_back(kCarriedProfiles[i].name);
	return names;
}

ist::Result<SimulatedProfile> simulatedProfile(const std::string& name)
{
	ist::Result<SimulatedProfile> profile = ist::Error{};
	std::string known;
	for (std::size_t i = 0; i < kCarriedProfileCount; ++i)
	{
		known += (i ? ", " : "") + std::string(kCarriedProfiles[i].name);
		if (name == kCarriedProfiles[i].name) profile = parseSimulatedProfile(kCarriedProfiles[i].text);
	}
	if (endsWith(name, ".json")) profile = profileFromFile(name);
	else if (!profile && profile.error().message.empty())
		return ist::Error{
			"No simulated device is called '" + name + "'; known ones are " + known + ", or a file that ends with .json", false};
	if (!profile) return profile;
	profile.value().info.uri = "sim:" + name;
	profile.value().info.serial = "simulated";
	return profile;
}
}  // namespace devicebridge
