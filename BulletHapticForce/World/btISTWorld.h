// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Law/btContactMaterial.h"
#include "BulletHapticForce/Solver/btVolumetricSolver.h"
#include "BulletHapticForce/World/btISTDebugDraw.h"
#include "BulletHapticForce/World/btISTSubsteps.h"
#include "BulletHapticForce/World/btISTWarnings.h"
#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"

#include "BulletCollision/BroadphaseCollision/btDbvtBroadphase.h"
#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h"
#include "BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h"

#include <memory>
#include <optional>
#include <string>

class btIDebugDraw;

/// A Bullet world with volumetric contact. It either makes its own world (configuration, dispatcher, broad phase, solver, world, made and
/// destroyed in the right order) or extends the world of a game. Bodies, shapes and constraints belong to the caller, who may remove them
/// before the world is destroyed or leave them in it. Attachments may outlive the world.
class btISTWorld
{
public:
	/// Makes a world with the gravity (0, -9.81, 0) m/s^2.
	btISTWorld();
	/// Extends the world of a game, which must outlive this object. Our algorithm is registered in its dispatcher. Our solver takes the
	/// place of the game's solver and has the same settings. While no tree is attached, the world moves as before, bit for bit. This
	/// never fails: see `solverRefusal`. The game may still step through its own `stepSimulation`.
	///
	/// A game has one btISTWorld at a time. A second one, or one after a registration that has set a pair rule, changes nothing. Its
	/// `attach`, `setGravity`, `step` and settings return an error, and its `materials` and `pairFilter` have no effect.
	explicit btISTWorld(btDiscreteDynamicsWorld& game);
	/// Returns the solver and the dispatch tables to the world of a game.
	~btISTWorld();
	btISTWorld(const btISTWorld&) = delete;
	btISTWorld& operator=(const btISTWorld&) = delete;

	btDiscreteDynamicsWorld& bullet() { return *m_world; }
	const btDiscreteDynamicsWorld& bullet() const { return *m_world; }
	/// Why the world of a game keeps its own solver (see installVolumetricSolver). Contact is then solved at its representative points,
	/// or by Bullet alone where the sentence says so. Empty when our solver is installed.
	const std::string& solverRefusal() const { return m_refusal; }
	/// Sets the gravity [m/s^2], like the world's own setGravity, but refuses values that are not finite. The stiffness of bodies without
	/// a material follows the gravity that the world and the bodies have in each step.
	std::optional<ist::Error> setGravity(const btVector3& gravity);
	/// Makes one step of `seconds`, in at most `setMostSubsteps` equal parts (btISTSubsteps). If `seconds` is not a positive finite
	/// number, the step is refused and nothing moves. Forces of the caller act over all parts.
	std::optional<ist::Error> step(double seconds);
	/// Sets the largest number of parts of a step. Default: 1, so that steps are never divided.
	void setMostSubsteps(int most) { m_mostSubsteps = most; }
	/// Number of parts of the last step.
	int substeps() const { return m_substeps; }
	/// Pairs that were too fast for the parts of the last step: one body may have passed through the other without a contact. A body that
	/// falls a quarter of a thickness from rest in one part is in the list, even while it lies still. A kinematic body moves its whole
	/// way in the first part, so more parts do not help. The pairs are counted in `passingPairs` too. Valid until the next step.
	const std::vector<btISTFastPair>& tooFast() const { return m_tooFast; }
	/// Number of such pairs since the world was made.
	uint64_t passingPairs() const { return m_passingPairs; }
	/// Statistics of our solver since it was made. All zero where the game keeps its own solver.
	const btVolumetricStatistics& statistics() const { return *m_statistics; }

	/// What may be wrong with the scene, counted since the world was made: deep contacts, bodies that passed through others, bodies
	/// without a valid box or inertia, and so on. The first of each kind is written to the log.
	const btISTWarnings& warnings() const { return m_warnings; }
	/// Sets where warnings are written. Default, or with an empty function: stderr. See btISTWarnings::Log.
	void setLog(btISTWarnings::Log log) { m_warnings.setLog(std::move(log)); }

	/// Attaches `tree` to `shape`. From the next step on, its contacts with all that is volumetric are found with the tree. See
	/// btISTRegistry::attach.
	[[nodiscard]] ist::Result<btISTAttachment> attach(const btCollisionShape* shape, std::shared_ptr<const ist::InnerSphereTree> tree);
	/// Attaches the tree of an .ist file. This call loads the file and blocks until it is loaded; btISTTreeSource loads and builds in the
	/// background.
	[[nodiscard]] ist::Result<btISTAttachment> attach(const btCollisionShape* shape, const std::string& path);
	/// See btContactMaterialTable.
	btContactMaterialTable& materials() { return *m_materials; }
	/// Sets which queries the contact cache may leave out (btISTContactCache). Default: only those whose answer cannot have changed.
	std::optional<ist::Error> setContactCache(const btISTContactCache& contactCache)
	{
		return m_registration.setContactCache(contactCache);
	}
	/// Decides which pairs are volumetric, and where. Default: all pairs, everywhere.
	btISTPairFilter& pairFilter() { return m_registration.pairFilter(); }
	/// Sets the accepted force error of all pairs: see btISTRegistration::setForceError.
	std::optional<ist::Error> setForceError(double share) { return m_registration.setForceError(share); }
	/// Sets the accepted force error of the pairs of one body, such as a held one: see btISTRegistration::setForceErrorOf.
	std::optional<ist::Error> setForceErrorOf(const btCollisionObject* body, std::optional<double> share)
	{
		return m_registration.setForceErrorOf(body, share);
	}
	/// Sets how many pairs of leaves a query may find: see btISTRegistration::setPairBudget.
	std::optional<ist::Error> setPairBudget(int64_t leafPairs) { return m_registration.setPairBudget(leafPairs); }
	/// Sets the number of threads that query pairs: see btISTRegistration::setQueryThreads.
	std::optional<ist::Error> setQueryThreads(int threads, double spinMicroseconds = 50)
	{
		return m_registration.setQueryThreads(threads, spinMicroseconds);
	}
	/// Sets how many pairs of bodies have a Verlet list of their near leaves: see btISTRegistration::setVerletLists.
	std::optional<ist::Error> setVerletLists(int pairsOfBodies, int leafPairs = 40000)
	{
		return m_registration.setVerletLists(pairsOfBodies, leafPairs);
	}
	/// Draws contacts and, if wanted, the balls of the trees, with the lines of Bullet's own interface; call it between steps. Draws
	/// nothing in the mode DBG_NoDebug. O(contacts, balls drawn), allocates nothing.
	void debugDraw(btIDebugDraw& drawer, const btISTDebugDraw& what = {});
	/// Contacts that the last step found, with the impulses that it applied.
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
	/// The parts of a world of our own, except the solver.
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
	std::unique_ptr<btSequentialImpulseConstraintSolver> m_solver;  // our solver
	std::unique_ptr<btDiscreteDynamicsWorld> m_own;
	btDiscreteDynamicsWorld* m_world;
	btConstraintSolver* m_gamesSolver = nullptr;  // the game's solver, which ours replaces
	bool m_gameOwnedIt = false;
	bool m_isSecond = false;  // the game already has a btISTWorld
	std::string m_refusal;
	const btVolumetricStatistics* m_statistics;
	btISTWarnings m_warnings{m_registration};
	btISTSubsteps m_plan;
	std::vector<btISTFastPair> m_tooFast;
	int m_mostSubsteps = 1, m_substeps = 1;
	uint64_t m_passingPairs = 0;
};
