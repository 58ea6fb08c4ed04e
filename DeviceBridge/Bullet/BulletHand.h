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
	double partMass = 0.03, palmMass = 0.3;         ///< what each part feels like, with what hangs behind it [kg]
	double stiffness = 3000, angularStiffness = 3;  ///< of the coupling of each part to its target [N/m, N m/rad]; its damping is critical
	double maxForce = 12, maxTorque = 0.4;          ///< that the coupling of a bone exerts at most [N, N m]
	double palmForce = 60, palmTorque = 4;          ///< and that of the palm
	double friction = 1;                            ///< of the skin; Bullet multiplies it with the object's
	btContactMaterial skin{5e7, 2};
	HandTrackingLimits watch;
};

/// Whether bodies touched in the last step: a contact whose pair was not looked at since, as where it sleeps, keeps what it was.
inline bool touchedInLastStep(const btISTContactStore& store, const btISTContact& contact) noexcept
{
	return contact.patchCount > 0 && contact.stamp + 1 == store.step();
}

/// A hand of sixteen rigid bodies in a world. Each is pulled to where the tracked hand has it by a spring and damper in six degrees of
/// freedom that saturates; none is ever put anywhere, so that fingers stop at what they meet. Parts touch everything, also each
/// other, except their neighbours in the chain, which overlap at the joints. They have no weight and never sleep.
/// One owner thread: that of the world. Destroyed before the world.
class BulletHand
{
public:
	/// The parts begin where `start` has them. Refused, with the reason: joints that are not tracked, the other hand, settings that are no
	/// positive finite numbers. What overlaps then is pushed out without a bang: a contact returns no more energy than it absorbed.
	static ist::Result<std::unique_ptr<BulletHand>> create(
		btISTWorld& world, std::shared_ptr<const HandModel> model, const HandState& start, const BulletHandSettings& settings = {});
	~BulletHand();
	BulletHand(const BulletHand&) = delete;
	BulletHand& operator=(const BulletHand&) = delete;

	/// Before each step of `h` [s] of the world: the targets move to `hand`, and the couplings pull. Bad samples: see HandTrackingMonitor.
	/// O(parts), no allocation.
	void drive(const HandState& hand, double h) noexcept;

	const HandModel& model() const noexcept { return *m_model; }
	btRigidBody& body(int part) const noexcept { return *m_parts[static_cast<std::size_t>(part)].body; }
	/// Which part a body is; -1 for others.
	int partOf(const btCollisionObject* object) const noexcept;
	/// Of the coupling on the part in the last step, about its centre of mass, World.
	const ist::Wrench& coupling(int part) const noexcept { return m_parts[static_cast<std::size_t>(part)].coupling; }
	const HandTrackingMonitor& pairFilter() const noexcept { return *m_watch; }

	/// Sums over the contacts of the last step that parts had, with other bodies and with each other.
	struct Touch
	{
		ist::Vec3 force[kHandParts];  ///< of the contacts on each part [N]
		int parts = 0;                ///< how many touch something that is not the hand
		std::int64_t pairs = 0;       ///< of all these contacts
		/// Contacts of parts with each other, and the sum of their forces [N]
		int selfContacts = 0;
		double selfForce = 0;
	};
	/// After a step of `h` [s] of the world. `only`: contacts with this body alone; null: all.
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
	std::unique_ptr<HandTrackingMonitor> m_watch;
};
}  // namespace devicebridge
