// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/btContactMaterial.h"
#include "BulletHapticForce/btISTSubsteps.h"
#include "BulletHapticForce/btVolumetricSolver.h"
#include "BulletISTCollision/btISTCollisionAlgorithm.h"

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h"
#include "BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h"

#include <memory>
#include <optional>

/// A Bullet world with volumetric contact: configuration, dispatcher, broad phase, solver, world, and the registration of the
/// algorithm, made and destroyed in the right order. Bodies, shapes and constraints belong to the caller, who removes them before
/// or leaves them behind; attachments may outlive the world. A game that has a world of its own needs none of this: it registers
/// the algorithm with its dispatcher and gives its world a btVolumetricSolver.
class btISTWorld
{
public:
	/// Gravity: (0, -9.81, 0) m/s^2.
	btISTWorld();
	~btISTWorld();
	btISTWorld(const btISTWorld&) = delete;
	btISTWorld& operator=(const btISTWorld&) = delete;

	btDiscreteDynamicsWorld& bullet() { return *m_world; }
	/// [m/s^2]. Also what sinkage under its own weight means for bodies without a material. Refused when not finite.
	std::optional<ist::Error> setGravity(const btVector3& gravity);
	/// One step of so many seconds, in at most `setMostSubsteps` equal parts (btISTSubsteps). Refused, and nothing moves, when that is not
	/// a positive finite number. Forces of the caller act over all parts.
	std::optional<ist::Error> step(double seconds);
	/// 1, as it is to begin with: never divided.
	void setMostSubsteps(int most) { m_mostSubsteps = most; }
	/// Into how many parts the last step was divided.
	int substeps() const { return m_substeps; }
	/// Pairs that were too fast for the parts that the last step had: one may have passed through the other without a contact. A body that
	/// falls a quarter of a thickness from rest in one part is among them, also where it lies still. A kinematic body takes its whole way in
	/// the first part, against which parts do not help. Counted in `passingPairs`, too. Valid until the next step.
	const std::vector<btISTFastPair>& tooFast() const { return m_tooFast; }
	/// All of them since the world was made.
	uint64_t passingPairs() const { return m_passingPairs; }
	/// What the solver did since the world was made.
	const btVolumetricStatistics& statistics() const { return m_solver->statistics(); }

	/// From the next step on, `shape` speaks through `tree` against everything that is volumetric. See btISTRegistry::attach.
	ist::Result<btISTAttachment> attach(const btCollisionShape* shape, std::shared_ptr<const ist::InnerSphereTree> tree);
	/// See btContactMaterialTable.
	btContactMaterialTable& materials() { return *m_materials; }
	/// Which pairs are volumetric, and where: all and everywhere, to begin with.
	btISTWatch& watch() { return m_registration.watch(); }
	/// What the last step found and did.
	btISTContactStore& contacts() { return m_registration.store(); }
	btISTRegistration& registration() { return m_registration; }

private:
	void stepInParts(double seconds, double part);

	btDefaultCollisionConfiguration m_configuration;
	btCollisionDispatcher m_dispatcher{&m_configuration};
	btDbvtBroadphase m_broadphase;
	std::shared_ptr<btContactMaterialTable> m_materials;
	btISTRegistration m_registration;
	std::unique_ptr<btVolumetricSolver<btSequentialImpulseConstraintSolver>> m_solver;
	std::unique_ptr<btDiscreteDynamicsWorld> m_world;
	btISTSubsteps m_plan;
	std::vector<btISTFastPair> m_tooFast;
	int m_mostSubsteps = 1, m_substeps = 1;
	uint64_t m_passingPairs = 0;
};
