// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Bullet/BulletHand.h"
#include "DeviceBridge/Loop/ContactSource.h"

namespace devicebridge
{
/// A tracked hand as the source of contact for a stepping thread that owns the world: in each tick the device's joints drive the sixteen
/// parts of a BulletHand, and the world takes a step. Several hands in one world share a loop (SteppingThread::addHand).
///
/// In a ToolStep, T is the palm's body frame. `coupling` is the sum of the couplings of all parts, about the palm. A contact is the sum
/// over the parts that touch the same body; `other` is that body, and contacts among the parts are left out. Without a usable sample, or
/// with an untracked palm, the hand counts as lost (HandTrackingMonitor). World, hand and device must outlive this object.
class BulletHandSource final : public ContactSource
{
public:
	/// `device` is the one that the loop reads, and `X_BW` its world W in Bullet's World B. `hand` is a hand in `world`.
	BulletHandSource(btISTWorld& world, BulletHand& hand, Device& device, const ist::Pose& X_BW);

	/// Drives the parts, for advance(), which calls it if the loop does not.
	void prepare(double dt, const DeviceState& hand) noexcept override;
	/// Advances the world, unless it has taken its step since prepare(). O(contacts). It allocates only when the world grows.
	void advance(double dt, const DeviceState& hand, ToolStep& step) noexcept override;

private:
	void sumCouplings(ToolStep& step) const noexcept;
	void collectContacts(double dt, ToolStep& step) const noexcept;
	ToolContact* contactWith(const void* other, ToolStep& step) const noexcept;

	btISTWorld& m_world;
	BulletHand& m_hand;
	Device& m_device;
	ist::Pose m_X_BW, m_X_WB;
	HandState m_joints;  // joints of the last sample, in World
	ist::Vec3 m_origin;  // position of the palm before the step, in World
	bool m_isPrepared = false;
	std::uint64_t m_preparedAt = 0;  // step of the world's store in which the parts were driven
};
}  // namespace devicebridge
