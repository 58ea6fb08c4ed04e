// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/HandParts.h"

namespace devicebridge
{
namespace
{
constexpr const char* kFingerNames[kHandFingers] = {"Index", "Middle", "Pinky", "Ring", "Thumb"};
constexpr HandJointIndex kFirstJoints[kHandFingers] = {kIndexProximal, kMiddleProximal, kLittleProximal, kRingProximal, kThumbMetacarpal};
}  // namespace

std::string handPartName(int part, bool left)
{
	const std::string side = left ? "L_" : "R_";
	if (part == kHandPart) return side + "Hand";
	return side + kFingerNames[fingerOf(part)] + std::to_string((part - 1) % 3 + 1);
}

HandJointIndex handPartJoint(int part)
{
	return part == kHandPart ? kPalm : static_cast<HandJointIndex>(kFirstJoints[fingerOf(part)] + (part - 1) % 3);
}

HandJointIndex handPartEnd(int part) { return part == kHandPart ? kWrist : static_cast<HandJointIndex>(handPartJoint(part) + 1); }
}  // namespace devicebridge
