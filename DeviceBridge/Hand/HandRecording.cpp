// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/HandRecording.h"

#include <algorithm>

namespace devicebridge
{
namespace
{
HandState withoutBadJoints(HandState hand)
{
	for (HandJoint& joint : hand.joints)
		if (!isFinite(joint.position) || !isNearUnit(joint.orientation) || !std::isfinite(joint.radius)) joint = {};
	return hand;
}

/// Appends a frame. If three frames are equal, the middle one is dropped.
void append(std::vector<HandMotion::Frame>& frames, const HandMotion::Frame& frame)
{
	const std::size_t n = frames.size();
	if (n >= 2 && isSameHand(frames[n - 2].hand, frames[n - 1].hand) && isSameHand(frames[n - 1].hand, frame.hand))
		frames.back().time = frame.time;
	else frames.push_back(frame);
}
}  // namespace

ist::Result<HandMotion> handMotionOf(const Recording& recording)
{
	if (recording.hands.empty() || recording.hands.size() != recording.ticks.size())
		return ist::Error{"the device of the recording (" + recording.info.model + ") senses no joints of a hand"};
	const auto good = [](const RecordedTick& tick) { return tick.readStatus == DeviceStatus::Ok; };
	const auto first = std::find_if(recording.ticks.begin(), recording.ticks.end(), good);
	if (first == recording.ticks.end()) return ist::Error{"the device of the recording (" + recording.info.model + ") never answered"};
	const auto end = std::find_if(recording.ticks.rbegin(), recording.ticks.rend(), good).base();
	HandState none;
	none.left = recording.hands[static_cast<std::size_t>(first - recording.ticks.begin())].left;
	HandMotion motion;
	for (auto tick = recording.ticks.begin(); tick != end; ++tick)
	{
		const double time = 1e-9 * static_cast<double>(tick->now - recording.ticks.front().now);
		append(motion.frames,
			{time, good(*tick) ? withoutBadJoints(recording.hands[static_cast<std::size_t>(tick - recording.ticks.begin())]) : none});
	}
	return motion;
}
}  // namespace devicebridge
