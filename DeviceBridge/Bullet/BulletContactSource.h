// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/World/btISTWorld.h"
#include "DeviceBridge/Coupling/AdaptiveCoupling.h"
#include "DeviceBridge/Loop/ContactSource.h"

namespace devicebridge
{
struct BulletToolSettings
{
	CouplingGains gains;
	ist::Pose X_BW;        ///< the device's world W in Bullet's World B; rigid, so that forces and lengths keep their size
	bool gravity = false;  ///< does gravity act on the tool? By default the hand carries it without feeling its weight
};

/// A Bullet world that the stepping thread owns: each tick is one step of it, and the tool is an ordinary body of the caller's on
/// a virtual coupling. What the coupling pulls the tool with is what the hand feels, so action equals reaction by construction.
///
/// T is the body's centre-of-mass frame. Contacts are those of the step: found at the pose in which it began, with the impulse that
/// it ended with divided by its length. `onTool` is about the origin of T in that pose, and so is `coupling`; `tool` is where the
/// step ended. World, store and tool outlive this; between ticks the thread that runs the ticks is their only owner.
class BulletContactSource final : public ContactSource
{
public:
	/// `tool` is a dynamic body of `world`, which fills `store`. One of mass 0, which Bullet never moves, is refused.
	/// From here on the tool is never put to sleep; on a static coupling it has the mass and
	/// inertia of staticMass(), though its weight stays.
	BulletContactSource(btDynamicsWorld& world, btISTContactStore& store, btRigidBody& tool, const BulletToolSettings& settings);
	BulletContactSource(btISTWorld& world, btRigidBody& tool, const BulletToolSettings& settings)
		: BulletContactSource(world.bullet(), world.contacts(), tool, settings)
	{}

	/// Without a pull when the hand is not finite or not rigid. On a static coupling a step of no length does nothing. O(bodies and
	/// contacts); allocates only when the world grows: what Bullet does, and a query at the first meeting of trees larger than any before.
	void advance(double dt, const DeviceState& hand, ToolStep& step) noexcept override;

	/// Why the tool cannot be led, as it came. If it is not empty, nothing pulls tool or hand; the world is stepped all the same.
	const char* refusal() const noexcept override { return m_refusal; }

	/// In W.
	ToolState toolState() const noexcept;

private:
	void adapt(double dt, const DeviceState& hand) noexcept;
	bool isFresh(const btISTContact& contact) const noexcept;
	bool isHeldByBullet() const noexcept;
	ist::Wrench pull(double dt, const DeviceState& hand) const noexcept;
	void forgetMomentum(double dt) noexcept;
	void applyToTool(const ist::Wrench& inW) noexcept;
	void collectContacts(double dt, const ist::Vec3& toolOrigin, ToolStep& step) const noexcept;
	ToolContact contactInW(const btISTContact& contact, double dt, const ist::Vec3& toolOrigin) const noexcept;

	btDynamicsWorld& m_world;
	btISTContactStore& m_store;
	btRigidBody& m_tool;
	BulletToolSettings m_settings;
	AdaptiveCoupling m_coupling;
	ist::Pose m_X_WB;
	double m_mass;  // of the tool as it came [kg]
	const char* m_refusal;
};
}  // namespace devicebridge
