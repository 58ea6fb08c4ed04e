// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/World/btISTWorld.h"
#include "DeviceBridge/Coupling/AdaptiveCoupling.h"
#include "DeviceBridge/Coupling/CouplingSwitch.h"
#include "DeviceBridge/Coupling/DeviceGains.h"
#include "DeviceBridge/Loop/ContactSource.h"

namespace devicebridge
{
struct BulletToolSettings
{
	/// Settings with gains for a device and ticks of `period` [s] (gainsForDevice): from its limits, else from those of its model's
	/// profile, else careful ones. `onAssumed` says what was assumed.
	static BulletToolSettings forDevice(const DeviceInfo& info, double period = 1e-3, const AssumptionListener& onAssumed = {})
	{
		BulletToolSettings settings;
		settings.gains = gainsForDevice(info, period, onAssumed);
		return settings;
	}

	CouplingGains gains;
	bool mayBeSilent = false;  ///< whether gains of zero are meant, with which the hand moves nothing and feels nothing
	ist::Pose X_BW;            ///< the device's world W in Bullet's World B; rigid, so that forces and lengths keep their size
	bool gravity = false;      ///< whether gravity acts on the tool. By default the hand carries the tool without feeling its weight
};

/// A Bullet world that the stepping thread owns: each tick is one step of it. The tool is an ordinary body of the caller's, on a virtual
/// coupling. The hand feels the reaction of the wrench with which the coupling pulls the tool, so action equals reaction by construction.
///
/// T is the body's centre-of-mass frame. Contacts are those of the step: they are found at the pose at its beginning. Their force is the
/// final impulse divided by the length of the step. `onTool` and `coupling` are about the origin of T in that pose; `tool` is the state
/// after the step. The sources of several hands in one world take one step together, if their hands share a loop
/// (SteppingThread::addHand). World, store and tool must outlive this object. Between ticks the thread that runs the ticks is their only
/// owner.
class BulletContactSource final : public ContactSource
{
public:
	/// `tool` is a dynamic body of `world`, and `world` fills `store`. A tool of mass 0 is refused, because Bullet never moves it. From now
	/// on the tool is never put to sleep. On a static coupling it has the mass and inertia of staticMass(), but keeps its weight.
	BulletContactSource(btDynamicsWorld& world, btISTContactStore& store, btRigidBody& tool, const BulletToolSettings& settings);
	BulletContactSource(btISTWorld& world, btRigidBody& tool, const BulletToolSettings& settings)
		: BulletContactSource(world.bullet(), world.contacts(), tool, settings)
	{}

	/// Pulls the tool, for advance(), which calls it if the loop does not.
	void prepare(double dt, const DeviceState& hand) noexcept override;
	/// Advances the world, unless it has taken its step since prepare(). The tool is not pulled if the hand is not finite or not rigid. On
	/// a static coupling a step of length 0 does nothing. O(bodies and contacts). It allocates only when the world grows: as Bullet does,
	/// and in the first query of trees larger than any before.
	void advance(double dt, const DeviceState& hand, ToolStep& step) noexcept override;

	/// Why the tool could not be coupled when it was passed in. If it is not empty, neither tool nor hand is pulled, but the world is
	/// stepped.
	const char* refusal() const noexcept override { return m_refusal; }

	/// State of the tool, in W.
	ToolState toolState() const noexcept;

	/// For any thread: lets the tool go, or takes hold of it again (CouplingSwitch). A static coupling stays on, because its tool has no
	/// momentum to go on by itself.
	void setCoupled(bool on) noexcept { m_switch.set(on || m_settings.gains.isStatic); }

private:
	void adapt(double dt, const DeviceState& hand) noexcept;
	bool isFresh(const btISTContact& contact) const noexcept;
	bool isHeldByBullet() const noexcept;
	ist::Wrench pull(double dt, const DeviceState& hand) const noexcept;
	void forgetMomentum(double dt) noexcept;
	void applyToTool(const ist::Wrench& inW) noexcept;
	void stepWorld(double dt, ToolStep& step) noexcept;
	void collectContacts(double dt, ToolStep& step) const noexcept;
	ToolContact contactInW(const btISTContact& contact, double dt) const noexcept;

	btDynamicsWorld& m_world;
	btISTContactStore& m_store;
	btRigidBody& m_tool;
	BulletToolSettings m_settings;
	AdaptiveCoupling m_coupling;
	CouplingSwitch m_switch;
	ist::Pose m_X_WB;
	double m_mass;  // mass of the tool when it was passed in [kg]
	bool m_isPrepared = false;
	std::uint64_t m_preparedAt = 0;  // step of the store in which the tool was pulled
	ist::Wrench m_pull;
	ist::Vec3 m_toolOrigin;  // position of the tool before the step, in World
	const char* m_refusal;
};
}  // namespace devicebridge
