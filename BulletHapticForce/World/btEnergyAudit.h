// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactStore.h"
#include "BulletISTCollision/Core/Base/Pose.h"

#include <vector>

class btDiscreteDynamicsWorld;
class btRigidBody;

/// Energies [J] at the end of a span of time, and what changed them during it. The sum kinetic + potential + contact has changed by
/// injected - physical - numerical + residual.
struct btEnergyBalance
{
	double kinetic = 0;    ///< kinetic energy of all rigid bodies that move
	double potential = 0;  ///< potential energy of these bodies in their gravity, 0 at the origin
	double contact = 0;    ///< energy stored in volumetric contacts, as the law defines it
	double physical = 0;   ///< energy dissipated by Hunt-Crossley damping, friction and the bodies' damping
	double numerical = 0;  ///< energy lost to finite steps and to what the law's energy does not account for; negative: gained
	/// energy from forces of the caller, from kinematic bodies through contacts of either kind, and from changes that the caller made
	/// between the steps
	double injected = 0;
	/// Rounding, and everything outside our solver: the rows of Bullet's solver (joints, contacts without trees) except the work of
	/// kinematic bodies through its contacts, and contacts with links of multibodies.
	double residual = 0;
};

/// Accounts for the energy of a world that has a btVolumetricSolver. Each part is computed where it arises, as impulse times mean
/// velocity, which is an identity for impulses. No part is a difference of the others, so `residual` is a check.
///
/// The energy of the contacts at the end of a step is known only when the next step finds their overlap. After n steps the balance
/// therefore ends at the beginning of the n-th: take one more step to close it.
///
/// Only the thread of the world may use it. Cost: O(bodies + contacts) a step; allocates only when bodies are added. Soft bodies and
/// multibodies are not counted.
class btEnergyAudit
{
public:
	/// Both arguments must outlive the audit. For `store` see btISTRegistration::store and btISTWorld::contacts.
	btEnergyAudit(btDiscreteDynamicsWorld& world, const btISTContactStore& store) : m_world(world), m_store(store) {}

	/// Call these two around each stepSimulation; it must make exactly one step of `h` [s].
	void beforeStep(double h);
	void afterStep();

	/// Balance of the step before the last.
	const btEnergyBalance& step() const { return m_step; }
	/// Balance since the first step.
	const btEnergyBalance& total() const { return m_total; }

private:
	struct Body
	{
		btRigidBody* body;
		ist::Vec3 position, gravity;
		ist::Mat3 inertia;          // World axes [kg m^2]
		ist::Twist before, pushed;  // twists at the beginning of the step, and after all impulses but those of contacts
		double gravityWork = 0;
	};
	struct Energies
	{
		double kinetic = 0, potential = 0;
		double sum() const { return kinetic + potential; }
	};
	Energies energies() const;
	void enterForces(Body& entry, double h);
	void enterMotion(const Body& entry);
	double kinematicWork(const btISTContact& contact, const btCollisionObject& body, double sign) const;

	btDiscreteDynamicsWorld& m_world;
	const btISTContactStore& m_store;
	std::vector<Body> m_bodies;
	btEnergyBalance m_step, m_total, m_open;  // m_open: the step in progress, afterwards the last step
	Energies m_begin, m_end;
	double m_contact = 0;
	bool m_first = true;
};
