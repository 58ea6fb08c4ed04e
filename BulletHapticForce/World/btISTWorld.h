// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Law/btContactMaterial.h"
#include "BulletHapticForce/Solver/btVolumetricSolver.h"
#include "BulletHapticForce/World/btISTSubsteps.h"
#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h"
#include "BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h"

#include <memory>
#include <optional>
#include <string>

/// A Bullet world with volumetric contact: one of its own (configuration, dispatcher, broad phase, solver, world, made and destroyed in
/// the right order), or the one that a game has. Bodies, shapes and constraints belong to the caller, who removes them before or
/// leaves them behind; attachments may outlive the world.
class btISTWorld
{
public:
	/// A world of its own. Gravity: (0, -9.81, 0) m/s^2.
	btISTWorld();
	/// The world of a game, which must outlive this: our algorithm goes into its dispatcher, our solver takes the place of the one it
	/// has, with that one's settings. While nothing is attached it moves as before, bit for bit. Never fails: see `solverRefusal`.
	/// Steps through `stepSimulation` of the game stay as they are. A game has one at a time: a second one, or one after a registration
	/// that has set a pair rule, changes nothing: `attach`, `setGravity`, `step` and the settings below are refused in words, and
	/// `materials` and `watch` have no effect.
	explicit btISTWorld(btDiscreteDynamicsWorld& game);
	/// The world of a game gets back its solver and its dispatch tables.
	~btISTWorld();
	btISTWorld(const btISTWorld&) = delete;
	btISTWorld& operator=(const btISTWorld&) = delete;

	btDiscreteDynamicsWorld& bullet() { return *m_world; }
	const btDiscreteDynamicsWorld& bullet() const { return *m_world; }
	/// Why the world of a game keeps a solver of its own kind (see installVolumetricSolver): contact is then carried by its representative
	/// points, or, where the sentence says so, stays Bullet's. Empty when all is well.
	const std::string& solverRefusal() const { return m_refusal; }
	/// [m/s^2]. The same as the world's own setGravity, but refused when not finite. The stiffness of bodies without a material follows the
	/// gravity that world and bodies have in each step.
	std::optional<ist::Error> setGravity(const btVector3& gravity);
	/// One step of so many seconds, in at most `setMostSubsteps` equal parts (btISTSubsteps). Refused, and nothing moves, when that is not
	/// a positive finite number. Forces of the caller act over all parts.
	std::optional<ist::Error> step(double seconds);
	/// 1, as it is to begin with: never divided.
	void setMostSubsteps(int most) { m_mostSubsteps = most; }
	/// Into how many parts the last step was divided.
	int substeps() const { return m_substeps; }
	/// Pairs that were too fast for the parts that the last step had: one may have passed through the other without a contact. A body that
	/// falls a quarter of a thickness from rest in one part is among them, also where it lies still. A kinematic body takes its whole way
	/// in the first part, against which parts do not help. Counted in `passingPairs`, too. Valid until the next step.
	const std::vector<btISTFastPair>& tooFast() const { return m_tooFast; }
	/// All of them since the world was made.
	uint64_t passingPairs() const { return m_passingPairs; }
	/// What the solver did since this was made; all zero where the world of a game keeps its own.
	const btVolumetricStatistics& statistics() const { return *m_statistics; }

	/// From the next step on, `shape` speaks through `tree` against everything that is volumetric. See btISTRegistry::attach.
	[[nodiscard]] ist::Result<btISTAttachment> attach(const btCollisionShape* shape, std::shared_ptr<const ist::InnerSphereTree> tree);
	/// The same with the tree of an .ist file, which is loaded here and now. btISTTreeSource loads and builds without anybody waiting.
	[[nodiscard]] ist::Result<btISTAttachment> attach(const btCollisionShape* shape, const std::string& path);
	/// See btContactMaterialTable.
	btContactMaterialTable& materials() { return *m_materials; }
	/// What queries may be left out; see btISTContactCache. To begin with only those whose answer cannot have changed.
	std::optional<ist::Error> setContactCache(const btISTContactCache& contactCache)
	{
		return m_registration.setContactCache(contactCache);
	}
	/// Which pairs are volumetric, and where: all and everywhere, to begin with.
	btISTPairFilter& pairFilter() { return m_registration.pairFilter(); }
	/// The force error that is accepted from now on, of each pair: see btISTRegistration::setForceError.
	std::optional<ist::Error> setForceError(double share) { return m_registration.setForceError(share); }
	/// The same for the pairs of one body, as the one in the hand: see btISTRegistration::setForceErrorOf.
	std::optional<ist::Error> setForceErrorOf(const btCollisionObject* body, std::optional<double> share)
	{
		return m_registration.setForceErrorOf(body, share);
	}
	/// How many pairs of leaves a query may find; see btISTRegistration::setPairBudget.
	std::optional<ist::Error> setPairBudget(int64_t leafPairs) { return m_registration.setPairBudget(leafPairs); }
	/// By how many threads pairs are queried; see btISTRegistration::setQueryThreads.
	std::optional<ist::Error> setQueryThreads(int threads, double spinMicroseconds = 50)
	{
		return m_registration.setQueryThreads(threads, spinMicroseconds);
	}
	/// How many pairs remember which of their leaves were near; see btISTRegistration::setVerletLists.
	std::optional<ist::Error> setVerletLists(int pairsOfBodies, int leafPairs = 40000)
	{
		return m_registration.setVerletLists(pairsOfBodies, leafPairs);
	}
	/// What the last step found and did.
	btISTContactStore& contacts() { return m_registration.store(); }
	btISTRegistration& registration() { return m_registration; }

	// Former names, until 0.4.
	[[deprecated("since 0.3: pairFilter")]] btISTPairFilter& watch() { return pairFilter(); }
	[[deprecated("since 0.3: setContactCache")]] std::optional<ist::Error> setEconomy(const btISTContactCache& cache)
	{
		return setContactCache(cache);
	}
	[[deprecated("since 0.3: setVerletLists")]] std::optional<ist::Error> setPairMemory(int pairsOfBodies, int leafPairs = 40000)
	{
		return setVerletLists(pairsOfBodies, leafPairs);
	}

private:
	/// The parts of a world, but the solver.
	struct Parts
	{
		btDefaultCollisionConfiguration configuration;
		btCollisionDispatcher dispatcher{&configuration};
		btDbvtBroadphase broadphase;
	};
	void stepInParts(double seconds, double part);
	void installInto(btDiscreteDynamicsWorld& game);
	void restore();
	void giveSolverBack();

	std::unique_ptr<Parts> m_parts;
	std::shared_ptr<btContactMaterialTable> m_materials;
	btISTRegistration m_registration;
	std::unique_ptr<btSequentialImpulseConstraintSolver> m_solver;  // ours
	std::unique_ptr<btDiscreteDynamicsWorld> m_own;
	btDiscreteDynamicsWorld* m_world;
	btConstraintSolver* m_gamesSolver = nullptr;  // whose place ours has
	bool m_gameOwnedIt = false;
	bool m_isSecond = false;  // the game has one already
	std::string m_refusal;
	const btVolumetricStatistics* m_statistics;
	btISTSubsteps m_plan;
	std::vector<btISTFastPair> m_tooFast;
	int m_mostSubsteps = 1, m_substeps = 1;
	uint64_t m_passingPairs = 0;
};
