// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Device/HandState.h"

#include <string>

namespace devicebridge
{
/// The rigid parts of a hand, in the order of their ids in GRAB (Taheri et al., GRAB: a dataset of whole-body human grasping, 2020). They
/// are the palm and three bones of each finger, from the knuckle to the tip. The thumb's first part is its metacarpal.
enum HandPart
{
	kHandPart,  ///< the palm, "Hand" in GRAB
	kIndex1,
	kIndex2,
	kIndex3,
	kMiddle1,
	kMiddle2,
	kMiddle3,
	kPinky1,
	kPinky2,
	kPinky3,
	kRing1,
	kRing2,
	kRing3,
	kThumb1,
	kThumb2,
	kThumb3,
	kHandParts
};
constexpr int kHandFingers = 5;

/// GRAB's label of the part: 21 and 26 to 40 for a left hand, 22 and 41 to 55 for a right one.
constexpr int handPartId(int part, bool left) { return part == kHandPart ? (left ? 21 : 22) : part + (left ? 25 : 40); }
/// GRAB's name: "R_Index1", "L_Hand".
std::string handPartName(int part, bool left);

/// Index of the part's finger: 0 to 4 for index, middle, little, ring finger and thumb, -1 for the palm.
constexpr int fingerOf(int part) { return part == kHandPart ? -1 : (part - 1) / 3; }
/// The next part towards the wrist; -1 for the palm.
constexpr int parentOf(int part) { return part == kHandPart ? -1 : (part - 1) % 3 == 0 ? int(kHandPart) : part - 1; }
/// Whether a joint connects the two parts, so that they overlap in every posture.
constexpr bool areNeighbours(int a, int b) { return parentOf(a) == b || parentOf(b) == a; }

/// The joint whose frame is the part's *joint frame*: the palm's, or the joint at which the bone begins, along -z.
HandJointIndex handPartJoint(int part);
/// The joint at the other end of the bone; for the palm, the wrist.
HandJointIndex handPartEnd(int part);
}  // namespace devicebridge
