// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Coupling/DeviceGains.h"

#include "DeviceBridge/Drivers/AssumedLimits.h"

namespace devicebridge
{
CouplingGains gainsForDevice(const DeviceInfo& info, double period, const AssumptionListener& onAssumed)
{
	DeviceInfo known = info;
	assumeLimits(known);
	CouplingGains gains = passiveGains(known, known.damping, known.angularDamping, period);
	std::string assumed;
	if (known.assumed) assumed = known.source;
	const auto say = [&](const std::string& what) { assumed += (assumed.empty() ? "" : "; ") + what; };
	const bool moves = (info.actuated & kTranslation) == kTranslation, turns = (info.actuated & kRotation) == kRotation;
	if (moves && !(gains.stiffness > 0))
	{
		gains.stiffness = kCarefulStiffness;
		say("no stiffness is known: 200 N/m is assumed");
	}
	if (moves && !(gains.maxForce > 0))
	{
		gains.maxForce = kCarefulForce;
		say("no largest force is known: 2 N is assumed");
	}
	if (turns && !(gains.angularStiffness > 0 && gains.maxTorque > 0)) say("no limits of the torque are known: no torque is exerted");
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
