// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactStore.h"
#include "BulletISTCollision/Core/Base/Pose.h"

#include <vector>

class btDiscreteDynamicsWorld;
class btRigidBody;

/// Energies [J] at the end of a span of time, and what happened in it. The sum kinetic + potential + contact has changed by
/// injected - physical - numerical + residual.
struct btEnergyBalance
{
	double kinetic = 0;    ///< of all rigid bodies that move
	double potential = 0;  ///< in their gravity, 0 at the origin
	double contact = 0;    ///< stored in volumetric contacts, by the law's own energy
	double physical = 0;   ///< dissipated by Hunt-Crossley, friction and the bodies' damping
	double numerical = 0;  ///< lost to steps of finite length and to what the law's energy does not account for; negative: gained
	double injected = 0;   ///< by forces of the caller, by kinematic bodies through contacts of either kind, and by what the caller changed
						   ///< between the steps
	/// Rounding, and all that is not ours: the rows of Bullet's solver (joints, contacts without trees) beyond what kinematic bodies do
	/// through its contacts, and contacts with links of multibodies.
	double residual = 0;
};

/// Keeps the energy of a world with btVolumetricSolver: every joule has a name. Each part is taken from where it arises, impulse
/// times mean velocity, an identity for impulses; none is a difference of the others, so that `residual` is a check.
///
/// The energy of the contacts at the end of a step is known when the next one finds their overlap. Hence after n steps the balance
/// reaches up to the beginning of the n-th: to close it after the last step of interest, take one more.
/// One owner thread: that of the world. O(bodies + contacts) a step; allocates only when bodies are added. Soft bodies and multibodies do
/// not count.
class btEnergyAudit
{
public:
	/// Both must outlive it. `store`: see btISTRegistration::store, btISTWorld::contacts.
	btEnergyAudit(btDiscreteDynamicsWorld& world, const btISTContactStore& store) : m_world(world), m_store(store) {}

	/// Around each stepSimulation that makes exactly one step of `h` [s].
	void beforeStep(double h);
	void afterStep();

	/// Of the step before the last.
	const btEnergyBalance& step() const { return m_step; }
	/// Since the first.
	const btEnergyBalance& total() const { return m_total; }

private:
	struct Body
	{
		btRigidBody* body;
		ist::Vec3 position, gravity;
		ist::Mat3 inertia;          // World axes
		ist::Twist before, pushed;  // at the beginning; with all but contacts
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
	btEnergyBalance m_step, m_total, m_open;  // m_open: of the step in progress, then of the last
	Energies m_begin, m_end;
	double m_contact = 0;
	bool m_first = true;
};
