// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/World/btISTWorld.h"
#include "DeviceBridge/Coupling/VirtualCoupling.h"
#include "DeviceBridge/Hand/HandTrackingMonitor.h"

#include "BulletCollision/CollisionShapes/btCollisionShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <memory>

namespace devicebridge
{
struct BulletHandSettings
{
	double partMass = 0.03, palmMass = 0.3;         ///< effective mass of each part, including what hangs behind it [kg]
	double stiffness = 3000, angularStiffness = 3;  ///< coupling of each part to its target, with critical damping [N/m, N m/rad]
	double maxForce = 12, maxTorque = 0.4;          ///< largest force and torque of the coupling of a bone [N, N m]
	double palmForce = 60, palmTorque = 4;          ///< largest force and torque of the coupling of the palm [N, N m]
	double friction = 1;                            ///< friction coefficient of the skin; Bullet multiplies it by the object's
	btContactMaterial skin{5e7, 2};
	HandTrackingLimits tracking;
};

/// Whether the bodies touched in the last step. A contact whose pair was not evaluated since, for example because it sleeps, keeps its old
/// patches.
inline bool touchedInLastStep(const btISTContactStore& store, const btISTContact& contact) noexcept
{
	return contact.patchCount > 0 && contact.stamp + 1 == store.step();
}

/// A hand of sixteen rigid bodies in a world. A spring and damper in six degrees of freedom, which saturates, pulls each body to its
/// tracked pose. The bodies are never set to a pose, so fingers stop at obstacles. Parts collide with everything, also with each other,
/// except with their neighbours in the chain, which overlap at the joints. They have no weight and never sleep. One owner thread: the
/// world's. Destroy the hand before the world.
class BulletHand
{
public:
	/// Creates the parts at the poses of `start`. Refused, with the reason: joints that are not tracked, the other hand, a sample that
	/// cannot be this hand (faultOf), settings that are not positive finite numbers. Bodies that overlap then are pushed apart without a
	/// jump, because a contact returns no more energy than it absorbed.
	static ist::Result<std::unique_ptr<BulletHand>> create(
		btISTWorld& world, std::shared_ptr<const HandModel> model, const HandState& start, const BulletHandSettings& settings = {});
	~BulletHand();
	BulletHand(const BulletHand&) = delete;
	BulletHand& operator=(const BulletHand&) = delete;

	/// Moves the targets to `hand` and applies the couplings; call it before each step of `h` [s] of the world. For bad samples see
	/// HandTrackingMonitor. O(parts), no allocation.
	void drive(const HandState& hand, double h) noexcept;

	const HandModel& model() const noexcept { return *m_model; }
	btRigidBody& body(int part) const noexcept { return *m_parts[static_cast<std::size_t>(part)].body; }
	/// The part whose body this is; -1 for other objects.
	int partOf(const btCollisionObject* object) const noexcept;
	/// Wrench of the coupling on the part in the last step, about the part's centre of mass, World.
	const ist::Wrench& coupling(int part) const noexcept { return m_parts[static_cast<std::size_t>(part)].coupling; }
	const HandTrackingMonitor& trackingMonitor() const noexcept { return *m_monitor; }
	[[deprecated("since 0.3: trackingMonitor")]] const HandTrackingMonitor& watch() const noexcept { return trackingMonitor(); }

	/// Sums over the contacts of the parts in the last step, with other bodies and with each other.
	struct Touch
	{
		ist::Vec3 force[kHandParts];  ///< sum of the contact forces on each part [N]
		int parts = 0;                ///< number of parts that touch something other than the hand
		std::int64_t pairs = 0;       ///< number of pairs of leaves in all these contacts
		/// Number of contacts between parts, and the sum of their forces [N].
		int selfContacts = 0;
		double selfForce = 0;
	};
	/// Call it after a step of `h` [s] of the world. `only` restricts the sums to contacts with this body; null: all.
	Touch touch(double h, const btCollisionObject* only = nullptr) const noexcept;

private:
	struct Part
	{
		std::unique_ptr<btCollisionShape> shape;
		std::unique_ptr<btRigidBody> body;
		btISTAttachment attachment;
		double mass = 0, inertia = 0;
		CouplingGains gains;
		ist::Wrench coupling;
	};
	BulletHand(btISTWorld& world, std::shared_ptr<const HandModel> model) : m_world(world), m_model(std::move(model)) {}
	std::optional<ist::Error> addPart(int part, const ist::Pose& X_WB, const BulletHandSettings& settings);

	btISTWorld& m_world;
	std::shared_ptr<const HandModel> m_model;
	std::array<Part, kHandParts> m_parts;
	std::unique_ptr<HandTrackingMonitor> m_monitor;
};
}  // namespace devicebridge
