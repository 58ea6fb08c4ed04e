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
	int pairs = 0;     ///< that were queried side by side
	int byOthers = 0;  ///< of them, not by the owner's thread
	int late = 0;      ///< of them, given up, and queried again by the owner
	/// While the store measures query time, processor time [us]: of all of these queries, of the owner's thread for them, waiting included,
	/// and of the busiest of as many threads that are never interrupted, each taking the next query when it is free.
	double sumMicroseconds = 0, ownMicroseconds = 0, pathMicroseconds = 0;
};

class btCollisionObject;
class btOverlappingPairCache;
class btISTInstallation;

/// Handle on what `registerAlgorithm` did; the last one to go puts back every entry of the dispatch tables that is still ours.
/// It must go before the dispatcher (or be told `dispatcherIsGone`). Pairs that exist keep their volumetric contact until they
/// are cleaned or the world goes: what they need they own. Move-only.
/// A handle without a registration is one that was default-made, released or moved from. All its functions may be called: `refusal` and
/// the setters say that there is no registration, getters give what a new one has, and `registry`, `store` and `watch` act on nothing.
/// These three belong to the handle, and live until it gets another registration or goes.
class [[nodiscard]] btISTRegistration
{
public:
	btISTRegistration() = default;
	~btISTRegistration();
	btISTRegistration(btISTRegistration&&) noexcept;
	btISTRegistration& operator=(btISTRegistration&&) noexcept;

	/// True while every entry of both tables is ours. False when someone registered after us (GImpact does): see `reinstall`; and always
	/// after a `refusal`.
	bool isRegistered() const;
	/// Why this has no effect on a dispatcher; empty as a rule. A dispatcher with threads keeps its tables, and its contact stays Bullet's.
	/// A dispatcher that has a registration with another registry keeps that one.
	const std::string& refusal() const;
	/// Takes back the entries that someone else wrote, and delegates to their functions. Refused where `refusal` is not empty.
	std::optional<ist::Error> reinstall();
	/// Makes the memory of the world's queries resident now, up to 30 MB. Otherwise pages come as contacts need them, which a step in a
	/// haptic thread feels once. Refused where `refusal` is not empty.
	std::optional<ist::Error> makeResident();
	/// What the destructor does. The handle then has no registration.
	void release();
	/// Forget the dispatcher and the pair cache without touching them.
	void dispatcherIsGone();

	btISTRegistry& registry();
	btISTContactStore& store();
	/// Keeps the store and all that its contacts need alive: for solvers, which may outlive the registration.
	std::shared_ptr<btISTContactStore> sharedStore() const;
	/// Which pairs are volumetric, and where.
	btISTPairFilter& pairFilter();
	/// Decides the constants of pairs from now on. Refused while another handle of this dispatcher lives that has set a rule: each
	/// btISTWorld sets one.
	std::optional<ist::Error> setPairRule(std::shared_ptr<const btISTPairRule> rule);
	/// No force before bodies surely overlap: see ist::QueryOptions::requireInnerOverlap. Off at first.
	std::optional<ist::Error> requireInnerOverlap(bool on);
	/// Two trees are asked only as finely as keeps their force within this share of the true one (ist::queryWithTolerance), 0 to 1; 0, as
	/// it is at first: always the leaves. Changes fade in over the next steps. The first time, all attached trees get levels
	/// (btISTRegistry::keepLevels). What each pair promises is in btISTContact::accuracy. Refused when it is no such share. Between steps
	/// only.
	std::optional<ist::Error> setForceError(double share);
	double forceError() const;
	/// The same for the pairs of one body, whatever is accepted of all others: coarse everywhere, say, and fine where the hand is. Of two
	/// such bodies the smaller share counts. Without a share the body is as all others; take it out before it is deleted. Meant for a few
	/// bodies: each is compared with in every query.
	std::optional<ist::Error> setForceErrorOf(const btCollisionObject* body, std::optional<double> share);
	/// What is accepted of this pair.
	double forceErrorOf(const btCollisionObject* a, const btCollisionObject* b) const;
	/// No query of two trees finds more pairs of leaves than this, 1 or more: where the two share more, balls of coarser levels answer in
	/// place of the leaves, levels fading into each other (ist::QueryOptions::maxPairs, blend), in half as many patches; where even the
	/// coarsest have more, they answer. For bodies that a game makes inside one another. btISTContact::level tells. -1, as it is at first:
	/// any number. All else is refused. The first time, all attached trees get levels (btISTRegistry::keepLevels). Between steps only.
	std::optional<ist::Error> setPairBudget(int64_t leafPairs);
	int64_t pairBudget() const;
	/// What may be left out of the queries; to begin with what changes nothing. Refused when the error is not within its range.
	std::optional<ist::Error> setContactCache(const btISTContactCache& contactCache);
	const btISTContactCache& contactCache() const;

	/// By how many threads the pairs of a step are queried, 1 to 64; 1 to begin with. The owner of the world is one of them, and he waits
	/// for none that has lost its processor for longer than his own longest query took; callbacks are called by him alone. A step is the
	/// same, bit for bit, for any number (with setVerletLists, where none was late). Only pairs that touched in the step before are queried
	/// side by side, of shapes that are not children of a compound, and only where that is worth it. Each thread has a workspace, which
	/// becomes resident as it is used, up to 30 MB. It spins for so many microseconds after each step before it sleeps: waking it takes
	/// tens of them. Refused out of range. Between steps only.
	std::optional<ist::Error> setQueryThreads(int threads, double spinMicroseconds = 50);
	int queryThreads() const;
	/// What was queried side by side in the last step; in a world without our solver, in the last one in which a pair was met.
	btISTSharedQueries sharedQueries() const;

	/// So many pairs of bodies remember which of their leaves were near each other (ist::VerletList), up to `leafPairs` each: where bodies
	/// move little from step to step, as in a hand, a query with patches costs about two fifths of what it does. The sums are the same but
	/// for the rounding of floats; contacts may be divided into patches as some steps before, and a query that was late and is asked again
	/// (setQueryThreads) may differ by that rounding, and in its patches. Pairs of two trees, at whatever level they answer. 0 to 1024
	/// pairs, none to begin with, of 17 bytes for each pair of leaves, of which there is room for 200 million in all; refused out of range,
	/// or where memory ends: all is as it was then. Between steps only.
	std::optional<ist::Error> setVerletLists(int pairsOfBodies, int leafPairs = 40000);
	int verletLists() const;

	/// From now on pairs are cleaned whenever a shape of theirs gains or loses a tree. Null to stop, at the latest when the cache dies.
	std::optional<ist::Error> setPairCache(btOverlappingPairCache* pairCache);
	/// Throws away the algorithms of all existing pairs; they are chosen anew in the next step. Between steps only.
	void cleanPairs(btOverlappingPairCache* pairCache);

	// Former names, until 0.4.
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
	mutable std::shared_ptr<Unregistered> m_unregistered;  // made when it is first asked for without a registration
	std::shared_ptr<const void> m_ruleClaim;               // lives while this handle decides the pair rule
};
