// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Motion/MotionDevice.h"

#include "DeviceBridge/Device/DeviceAddress.h"
#include "DeviceBridge/Drivers/BuiltDrivers.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Hand/BvhHand.h"

namespace devicebridge
{
namespace
{
using MadeDevice = ist::Result<std::unique_ptr<Device>>;

bool endsWith(const std::string& text, const std::string& end)
{
	return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

MadeDevice makeMotion(const std::string& rest)
{
	DeviceAddress address(rest);
	const std::string hand = address.take("hand").value_or("right");
	if (hand != "left" && hand != "right") return ist::Error{"'motion:" + rest + "': hand=" + hand + " must be left or right"};
	if (const std::string unknown = address.leftOver(); !unknown.empty()) return ist::Error{"'motion:" + rest + "': " + unknown};
	BvhHandOptions bvh;
	bvh.left = hand == "left";
	ist::Result<HandMotion> motion = endsWith(address.path(), ".bvh") ? loadBvhHand(address.path(), bvh) : loadHandMotion(address.path());
	if (!motion) return motion.error();
	if (motion.value().frames.empty()) return ist::Error{address.path() + ": the motion has no frame"};
	return MadeDevice(std::make_unique<MotionDevice>(std::move(motion).value(), "motion:" + rest));
}
}  // namespace

MotionDevice::MotionDevice(HandMotion motion, const std::string& uri) : m_motion(std::move(motion))
{
	m_info.model = "recorded hand";
	m_info.uri = uri;
	m_info.sensed = kTranslation | kRotation | kHandJointsSensed;
	m_info.handedness = m_motion.frames.front().hand.left ? Handedness::Left : Handedness::Right;
}

DeviceStatus MotionDevice::open() noexcept
{
	m_open = true;
	m_reads = 0;
	m_palm = {};
	return DeviceStatus::Ok;
}

DeviceStatus MotionDevice::read(std::int64_t now, DeviceState& state) noexcept
{
	if (!m_open) return DeviceStatus::NotOpen;
	if (m_reads == 0) m_start = now;
	// The same expression as in handMotionOf, so that the times are equal to the last bit.
	const double time = m_motion.frames.front().time + 1e-9 * static_cast<double>(now - m_start);
	if (time > m_motion.frames.back().time) return DeviceStatus::Disconnected;
	m_hand = m_motion.at(time);
	const HandJoint& palm = m_hand.joints[kPalm];
	if (palm.tracked) m_palm = {rotationMatrix(palm.orientation), palm.position};
	state = {};
	state.sequence = ++m_reads;
	state.sampledAt = now;
	state.X_WH = m_palm;
	state.velocityEstimated = true;
	if (!palm.tracked) state.flags &= ~static_cast<std::uint32_t>(kHandPresent);
	return DeviceStatus::Ok;
}

bool MotionDevice::readHand(HandState& hand) noexcept
{
	if (!m_open || m_reads == 0) return false;
	hand = m_hand;
	return true;
}

void addMotion(DeviceRegistry& registry)
{
	registry.addScheme("motion", makeMotion, "the recorded motion of a hand: a CSV of `devicebridge record --hand`, or a BVH file");
}
}  // namespace devicebridge
