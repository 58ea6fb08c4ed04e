// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/AssumedLimits.h"

#include <algorithm>
#include <cctype>
#include <optional>

#include "DeviceBridge/Drivers/Simulated/SimulatedProfile.h"

namespace devicebridge
{
namespace
{
constexpr double kTick = 1e-3;                              // [s]
const std::string kAssumed = "assumed, ", kBetween = "; ";  // before what is assumed, and between the parts of a source

struct Limit
{
	AssumedLimit bit;
	double DeviceInfo::*value;
	unsigned needs;  // actuators of which the device must have at least one; 0: none
	const char* name;
};
constexpr Limit kLimits[] = {{kAssumedPeakForce, &DeviceInfo::peakForce, kTranslation, "peak_force"},
	{kAssumedContinuousForce, &DeviceInfo::continuousForce, kTranslation, "continuous_force"},
	{kAssumedPeakTorque, &DeviceInfo::peakTorque, kRotation, "peak_torque"},
	{kAssumedContinuousTorque, &DeviceInfo::continuousTorque, kRotation, "continuous_torque"},
	{kAssumedMaxStiffness, &DeviceInfo::maxStiffness, kTranslation, "max_stiffness"},
	{kAssumedMaxAngularStiffness, &DeviceInfo::maxAngularStiffness, kRotation, "max_angular_stiffness"},
	{kAssumedMaxDamping, &DeviceInfo::maxDamping, kTranslation, "max_damping"},
	{kAssumedMaxAngularDamping, &DeviceInfo::maxAngularDamping, kRotation, "max_angular_damping"},
	{kAssumedDamping, &DeviceInfo::damping, kTranslation, "damping"},
	{kAssumedAngularDamping, &DeviceInfo::angularDamping, kRotation, "angular_damping"},
	{kAssumedWorkspaceRadius, &DeviceInfo::workspaceRadius, 0, "workspace_radius"}};

std::string plain(const std::string& text)
{
	std::string letters;
	for (const char c : text)
		if (std::isalnum(static_cast<unsigned char>(c))) letters += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
	return letters;
}

bool isSameMaker(const std::string& a, const std::string& b)
{
	return !a.empty() && !b.empty() && (a.find(b) != std::string::npos || b.find(a) != std::string::npos);
}

/// A profile in the library's memory. A name that comes from a plug-in must not cause a file to be read.
std::optional<DeviceInfo> carried(const std::string& name)
{
	const std::vector<std::string> names = simulatedProfileNames();
	if (std::find(names.begin(), names.end(), name) == names.end()) return std::nullopt;
	const auto profile = simulatedProfile(name);
	return profile ? std::optional<DeviceInfo>(profile.value().info) : std::nullopt;
}

/// Removes a continuous limit that is as high as the peak, because no source gives it: unknown is safer.
void dropDoubtful(DeviceInfo& profile, const DeviceInfo& told)
{
	const auto isDoubtful = [](double continuous, double peak, double toldPeak) {
		return continuous >= peak || (toldPeak > 0 && continuous >= toldPeak);
	};
	if (isDoubtful(profile.continuousForce, profile.peakForce, told.peakForce)) profile.continuousForce = 0;
	if (isDoubtful(profile.continuousTorque, profile.peakTorque, told.peakTorque)) profile.continuousTorque = 0;
}

/// Fills missing limits. Returns their bits.
unsigned fillFrom(const DeviceInfo& profile, DeviceInfo& info)
{
	unsigned filled = 0;
	for (const Limit& limit : kLimits)
	{
		double& value = info.*limit.value;
		if (value > 0 || (limit.needs != 0 && !(info.actuated & limit.needs)) || !(profile.*limit.value > 0)) continue;
		value = profile.*limit.value;
		filled |= limit.bit;
	}
	return filled;
}

void say(DeviceInfo& info, const std::string& what) { info.source += (info.source.empty() ? "" : kBetween) + what; }

std::string listOf(unsigned bits)
{
	std::string list;
	for (const std::string& name : namesOfAssumed(bits)) list += (list.empty() ? "" : ", ") + name;
	return list;
}
}  // namespace

std::string profileOfModel(const std::string& maker, const std::string& model)
{
	for (const std::string& name : simulatedProfileNames())
	{
		const auto profile = simulatedProfile(name);
		if (!profile || plain(profile.value().info.model) != plain(model)) continue;
		if (isSameMaker(plain(profile.value().info.maker), plain(maker))) return name;
	}
	return {};
}

void assumeLimits(DeviceInfo& info)
{
	if (info.profile.empty()) info.profile = profileOfModel(info.maker, info.model);
	unsigned filled = 0;
	if (std::optional<DeviceInfo> known = carried(info.profile))
	{
		dropDoubtful(*known, info);
		filled = fillFrom(*known, info);
	}
	info.assumed |= filled;
	if (filled) say(info, kAssumed + "of the profile " + info.profile + ": " + listOf(filled));
	else info.profile.clear();
	DeviceInfo careful;
	careful.peakForce = kCarefulForce;
	filled = fillFrom(careful, info);
	info.assumed |= filled;
	if (filled) say(info, kAssumed + "because nothing is known, 2 N: " + listOf(filled));
	DeviceInfo least;
	least.damping = info.maxStiffness * kTick / 2;
	least.angularDamping = info.maxAngularStiffness * kTick / 2;
	filled = fillFrom(least, info);
	info.assumed |= filled;
	if (filled) say(info, kAssumed + "the least with which the stiffness is passive at 1 kHz: " + listOf(filled));
	if ((info.actuated & kTranslation) && !(info.maxStiffness > 0)) say(info, "unknown: max_stiffness");
}

std::string assumedInWords(const DeviceInfo& info)
{
	std::string words;
	const std::string source = info.assumed ? info.source : "";
	for (std::size_t at = 0; at < source.size();)
	{
		const std::size_t end = std::min(source.find(kBetween, at), source.size());
		if (source.compare(at, kAssumed.size(), kAssumed) == 0) words += (words.empty() ? "" : kBetween) + source.substr(at, end - at);
		at = end + kBetween.size();
	}
	return words;
}

std::vector<std::string> namesOfAssumed(unsigned assumed)
{
	std::vector<std::string> names;
	for (const Limit& limit : kLimits)
		if (assumed & limit.bit) names.push_back(limit.name);
	return names;
}
}  // namespace devicebridge
