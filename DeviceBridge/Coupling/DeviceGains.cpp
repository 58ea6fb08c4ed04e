// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Coupling/DeviceGains.h"

#include <algorithm>

namespace devicebridge
{
CouplingGains gainsForDevice(const DeviceInfo& info, double period, const AssumptionListener& onAssumed)
{
	const double scale = info.scale > 0 ? info.scale : 1;
	DeviceInfo known = info;
	scaleLimits(known, 1 / scale);
	assumeLimits(known);
	CouplingGains gains = passiveGains(known, known.damping, known.angularDamping, period);
	std::string assumed = assumedInWords(known);
	const auto say = [&](const std::string& what) { assumed += (assumed.empty() ? "" : "; ") + what; };
	const bool moves = info.actuated & kTranslation, turns = info.actuated & kRotation;
	if (moves && !(gains.stiffness > 0))
	{
		const double passive = known.damping > 0 ? 2 * known.damping / period : kCarefulStiffness;
		gains.stiffness = std::min(kCarefulStiffness, passive);
		say("no stiffness is known: at most 200 N/m is assumed");
	}
	if (turns && !(gains.angularStiffness > 0 && gains.maxTorque > 0)) say("no limits of the torque are known: no torque is exerted");
	gains.stiffness /= scale * scale;
	gains.maxForce /= scale;
	// The tool alone feels these, so they are not scaled.
	if (!moves && !turns)
	{
		gains.stiffness = kCarefulStiffness;
		gains.maxForce = kCarefulForce;
		if ((info.sensed & kRotation) == kRotation) gains.angularStiffness = kCarefulAngularStiffness, gains.maxTorque = kCarefulTorque;
		say("it exerts no force: 200 N/m and 2 N lead the tool");
	}
	const std::string name = info.model.empty() ? "the device" : info.model;
	if (onAssumed && !assumed.empty()) onAssumed(name + ": " + assumed);
	return gains;
}

const char* whyNotMoved(const CouplingGains& gains) noexcept
{
	const bool goes = (gains.stiffness > 0 || gains.damping > 0) && gains.maxForce > 0;
	const bool turns = (gains.angularStiffness > 0 || gains.angularDamping > 0) && gains.maxTorque > 0;
	return goes || turns
		? ""
		: "the gains of the coupling are zero, so the hand would move nothing and feel nothing: take the settings of forDevice(), or "
		  "set gains.stiffness and gains.maxForce. If you mean it, set mayBeSilent";
}
}  // namespace devicebridge
