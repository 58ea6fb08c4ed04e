// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/HandSampleFault.h"

#include <algorithm>

using namespace ist;

namespace devicebridge
{
namespace
{
constexpr int kFewestBones = 8;
constexpr double kCollapsed = 0.02, kSmallest = 0.5, kLargest = 2;  // lengths of bones over those of the model
constexpr double kLeastMillimetres = 500, kMostMillimetres = 2000;
constexpr double kOrigin = 1e-6;    // [m]
constexpr double kBreadth = 0.005;  // least distance of the outer knuckles across the palm that tells the side [m]

const HandJoint& jointOf(const HandState& hand, HandJointIndex joint) { return hand.joints[static_cast<std::size_t>(joint)]; }

bool isUsable(const HandJoint& joint) { return joint.tracked && isFinite(joint.position); }

/// Median of the lengths of the bones over those of the model; negative if too few are known.
double medianLength(const HandState& hand, const HandShape& shape)
{
	std::array<double, kHandParts> shares;
	int count = 0;
	for (int part = kHandPart + 1; part < kHandParts; ++part)
	{
		const HandJoint &begin = jointOf(hand, handPartJoint(part)), &end = jointOf(hand, handPartEnd(part));
		const double length = shape.bones[static_cast<std::size_t>(part)].length;
		if (!isUsable(begin) || !isUsable(end) || !(length > 0)) continue;
		shares[static_cast<std::size_t>(count++)] = distance(begin.position, end.position) / length;
	}
	if (count < kFewestBones) return -1;
	const auto middle = shares.begin() + count / 2;
	std::nth_element(shares.begin(), middle, shares.begin() + count);
	return *middle;
}

/// Whether the little finger's knuckle stands on the thumb's side. The back of the hand and the fingers' direction give the palm's axes.
bool isMirrored(const HandState& hand)
{
	const HandJoint &palm = jointOf(hand, kPalm), &index = jointOf(hand, kIndexProximal), &little = jointOf(hand, kLittleProximal);
	if (!isUsable(palm) || !isUsable(index) || !isUsable(little) || !isNearUnit(palm.orientation)) return false;
	const Vec3 right = rotationMatrix(palm.orientation) * Vec3{1, 0, 0};
	const double across = dot(little.position - index.position, right) * (hand.left ? -1 : 1);
	return across < -kBreadth;
}

bool hasRadius(const HandState& hand)
{
	return std::any_of(hand.joints.begin(), hand.joints.end(), [](const HandJoint& j) { return j.tracked && j.radius > 0; });
}
}  // namespace

const char* describe(HandSampleFault fault) noexcept
{
	switch (fault)
	{
	case HandSampleFault::None:
	case HandSampleFault::Count: break;
	case HandSampleFault::AtOrigin: return "all joints lay in the origin";
	case HandSampleFault::Collapsed: return "all joints lay in one place";
	case HandSampleFault::Millimetres: return "the bones were a thousand times too long: positions must be in metres";
	case HandSampleFault::WrongSize: return "the bones had less than half or more than twice the length of the model's";
	case HandSampleFault::Mirrored: return "the fingers stood in the order of the other hand";
	case HandSampleFault::NoRadius: return "no joint had a radius";
	case HandSampleFault::Frozen: return "the joints repeated bit for bit";
	}
	return "";
}

HandSampleFault faultOf(const HandState& hand, const HandShape& shape) noexcept
{
	const double length = medianLength(hand, shape);
	if (length < 0) return HandSampleFault::None;
	if (length < kCollapsed) return norm(jointOf(hand, kPalm).position) < kOrigin ? HandSampleFault::AtOrigin : HandSampleFault::Collapsed;
	if (length > kLeastMillimetres && length < kMostMillimetres) return HandSampleFault::Millimetres;
	if (length < kSmallest || length > kLargest) return HandSampleFault::WrongSize;
	if (isMirrored(hand)) return HandSampleFault::Mirrored;
	return hasRadius(hand) ? HandSampleFault::None : HandSampleFault::NoRadius;
}
}  // namespace devicebridge
