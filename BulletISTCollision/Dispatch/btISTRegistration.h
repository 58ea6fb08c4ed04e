// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactStore.h"
#include "BulletISTCollision/Registry/btISTPairFilter.h"
#include "BulletISTCollision/Registry/btISTRegistry.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include <memory>
#include <optional>
#include <string>

/// The queries that the threads of a world shared in a step (btISTRegistration::setQueryThreads).
struct btISTSharedQueries
{
	int pairs = 0;     ///< number of pairs that were queried in parallel
	int byOthers = 0;  ///< number of these pairs that other threads than the owner's took
	int late = 0;      ///< number of these pairs whose thread was late, so that the owner queried them again
	/// Processor times [us], measured while the store measures query time: the sum over all of these queries; the owner's thread, its
	/// waiting included; and the critical path. The critical path is the time of the busiest of the same number of threads, without
	/// interruptions, if each takes the next query as soon as it is free.
	double sumMicroseconds = 0, ownMicroseconds = 0, pathMicroseconds = 0;
};

class btCollisionObject;
class btOverlappingPairCache;
class btISTInstallation;

/// Handle on a registration that `registerAlgorithm` made. The last handle of a dispatcher restores every entry of the dispatch tables
/// that is still ours. Destroy the handle before the dispatcher, or call `dispatcherIsGone`. Existing pairs keep their volumetric contact
/// until they are cleaned or the world is destroyed, because they own all that they need. Move-only.
///
/// A handle has no registration when it was default-constructed, released or moved from. All its functions may still be called: `refusal`
/// and the setters say that there is no registration, and getters return the defaults. `registry`, `store` and `pairFilter` then return
/// objects without effect, which belong to the handle. They live until the handle is destroyed or gets another registration.
class [[nodiscard]] btISTRegistration
{
public:
	btISTRegistration() = default;
	~btISTRegistration();
	btISTRegistration(btISTRegistration&&) noexcept;
	btISTRegistration& operator=(btISTRegistration&&) noexcept;

	/// True while every entry of both tables is ours. It is false after another library registered later (GImpact does; see `reinstall`),
	/// and always false after a `refusal`.
	bool isRegistered() const;
	/// The reason why this has no effect on a dispatcher; normally empty. A dispatcher with threads is refused: its contact stays
	/// Bullet's. A dispatcher that has a registration with another registry is refused, too, and keeps that one.
	const std::string& refusal() const;
	/// Takes back the entries that others overwrote, and delegates to their functions. Refused if `refusal` is not empty.
	std::optional<ist::Error> reinstall();
	/// Makes the memory of the world's queries resident now, up to 35 MB. Otherwise the first contacts cause page faults, which delay a
	/// step of a haptic thread once. Refused if `refusal` is not empty.
	std::optional<ist::Error> makeResident();
	/// Does what the destructor does. The handle then has no registration.
	void release();
	/// Forgets the dispatcher and the pair cache without touching them.
	void dispatcherIsGone();

	btISTRegistry& registry();
	btISTContactStore& store();
	/// The store, shared: it stays alive with all that its contacts need. Meant for solvers, which may outlive the registration.
	std::shared_ptr<btISTContactStore> sharedStore() const;
	/// The filter that says which pairs are volumetric, and where.
	btISTPairFilter& pairFilter();
	/// Sets the rule that decides the constants of pairs from now on. Refused while another living handle of this dispatcher has set a
	/// rule: each btISTWorld sets one.
	std::optional<ist::Error> setPairRule(std::shared_ptr<const btISTPairRule> rule);
	/// If true, there is no force before bodies surely overlap: see ist::QueryOptions::requireInnerOverlap. Off by default.
	std::optional<ist::Error> requireInnerOverlap(bool on);
	/// Tolerance of the force between two trees, as a share of the true force, 0 to 1. A query uses the coarsest level whose error bound
	/// meets it (ist::queryWithTolerance). 0 (default): the leaves always answer. Changes of level fade in over the next steps. The first
	/// call adds levels to all attached trees (btISTRegistry::keepLevels). btISTContact::accuracy holds the error bound of each pair.
	/// Refused if the share is out of range. Call it between steps only.
	std::optional<ist::Error> setForceError(double share);
	double forceError() const;
	/// Tolerance for the pairs of one body, in place of `forceError`: for example coarse everywhere and fine where the hand is. If both
	/// bodies of a pair have one, the smaller counts. Without a share the body is treated as all others; do this before you delete the
	/// body. Meant for a few bodies, because each query compares with each of them.
	std::optional<ist::Error> setForceErrorOf(const btCollisionObject* body, std::optional<double> share);
	/// The tolerance of this pair.
	double forceErrorOf(const btCollisionObject* a, const btCollisionObject* b) const;
	/// Largest number of leaf pairs in a query of two trees, 1 or more; -1 (default): no limit. Other values are refused. Meant for
	/// bodies that a game creates inside one another. If two trees share more leaf pairs, balls of coarser levels answer in place of the
	/// leaves, in half as many patches, and levels fade into each other (ist::QueryOptions::maxPairs, blend). The coarsest level answers
	/// even if it has more pairs. btISTContact::level tells which level answered. The first call adds levels to all attached trees
	/// (btISTRegistry::keepLevels). Call it between steps only.
	std::optional<ist::Error> setPairBudget(int64_t leafPairs);
	int64_t pairBudget() const;
	/// Sets which queries may be skipped. The default skips only queries whose result cannot differ. Refused if the error is out of
	/// range.
	std::optional<ist::Error> setContactCache(const btISTContactCache& contactCache);
	const btISTContactCache& contactCache() const;

	/// Number of threads that query the pairs of a step, 1 to 64; default 1. The owner's thread of the world is one of them. It waits for
	/// a preempted worker at most as long as its own longest query took, then repeats that query itself. Only the owner's thread calls
	/// callbacks. A step is bitwise equal for any number of threads; with setVerletLists, if no thread was late. Queries run in parallel
	/// only for pairs that touched in the step before, whose shapes are not children of a compound, and only if it is worth the cost.
	/// Each thread has a workspace, which becomes resident as it is used, up to 30 MB. A thread spins for `spinMicroseconds` after each
	/// step before it sleeps, because waking it takes tens of microseconds. Refused out of range. Call it between steps only.
	std::optional<ist::Error> setQueryThreads(int threads, double spinMicroseconds = 50);
	int queryThreads() const;
	/// The parallel queries of the last step. In a world without our solver: of the last step in which a pair was processed.
	btISTSharedQueries sharedQueries() const;

	/// Number of pairs of bodies that have a Verlet list of leaf pairs (ist::VerletList), 0 to 1024; default 0. For slowly moving pairs,
	/// such as fingers on an object, a query with patches takes about 40 % of its normal time. `leafPairs` is the capacity of each list,
	/// at 17 bytes per pair of leaves; all lists together hold at most 200 million. They serve pairs of two trees wherever leaves
	/// or a level answer; surfaces need none. The sums differ only by the rounding of floats. Contacts may be divided into the patches of
	/// some steps before. A late query that is repeated (setQueryThreads) may differ by that rounding, and in its patches. Refused out of
	/// range or when memory runs out; then nothing changes. Call it between steps only.
	std::optional<ist::Error> setVerletLists(int pairsOfBodies, int leafPairs = 40000);
	int verletLists() const;

	/// From now on pairs are cleaned whenever one of their shapes gains or loses a tree. Null stops this; do so before the cache is
	/// deleted.
	std::optional<ist::Error> setPairCache(btOverlappingPairCache* pairCache);
	/// Destroys the algorithms of all existing pairs; they are chosen again in the next step. Call it between steps only.
	void cleanPairs(btOverlappingPairCache* pairCache);

	// Former names, kept until 0.4.
	[[deprecated("since 0.3: pairFilter")]] btISTPairFilter& watch() { return pairFilter(); }
	[[deprecated("since 0.3: requireInnerOverlap")]] std::optional<ist::Error> setGate(bool on) { return requireInnerOverlap(on); }
	[[deprecated("since 0.3: setContactCache")]] std::optional<ist::Error> setEconomy(const btISTContactCache& cache)
	{
		return setContactCache(cache);
	}
	[[deprecated("since 0.3: contactCache")]] const btISTContactCache& economy() const { return contactCache(); }
	[[deprecated("since 0.3: setVerletLists")]] std::optional<ist::Error> setPairMemory(int pairsOfBodies, int leafPairs = 40000)
	{
		return setVerletLists(pairsOfBodies, leafPairs);
	}
	[[deprecated("since 0.3: verletLists")]] int pairMemory() const { return verletLists(); }

private:
	friend class btISTCollisionAlgorithm;
	struct Unregistered;
	Unregistered& unregistered() const;

	std::shared_ptr<btISTInstallation> m_installation;
	mutable std::shared_ptr<Unregistered> m_unregistered;  // created at the first access without a registration
	std::shared_ptr<const void> m_ruleClaim;               // alive while this handle decides the pair rule
};
