// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"

#include <functional>
#include <string>
#include <vector>

class btCollisionObject;
class btCollisionWorld;
class btISTWorld;

/// How one pair of shapes is answered: a pair of bodies has several when they are compounds.
struct btISTPairReport
{
	enum Model
	{
		None,        ///< nobody looks at it
		Stock,       ///< Bullet's own contact
		HalfSpace,   ///< leaves against a plane: exact caps
		ClosedForm,  ///< leaves against Bullet's box, sphere, capsule, cylinder or cone
		Trees        ///< leaves against leaves
	};

	const btCollisionObject *bodyA = nullptr, *bodyB = nullptr;
	Model model = None;
	std::string reason;  ///< why this model, and why it was asked or not asked in the last step
	int level = 0;       ///< of the trees: 0 the leaves, each step above a third of one body's
	int patches = 0;
	int64_t leafPairs = 0;
	double force = 0;                                              ///< of the pressure, without damping and friction [N]
	double k = 0;                                                  ///< stiffness in the last step [Pa/m]; 0 where `model` is not ours
	btISTStiffnessRule stiffnessRule = btISTStiffnessRule::Given;  ///< what decided `k`
	double depth = 0;                                              ///< of the deepest patch in the last step, volume over area [m]
	double deepest = 0;  ///< largest depth since the pair began, as a share of the thinner body's thickness (btISTSubsteps::thickness)
	/// Expected error of the force as a share of the larger of the force and the floor (btISTContactCache): the error bar of the query, and
	/// on top of it what was granted to a result that is kept. Not a number where nothing is promised.
	double expectedError = 0;
	/// Of two trees where a force error is accepted (btISTWorld::setForceError, setForceErrorOf): what is accepted of this pair, the error
	/// that 95 % of such contacts stay under at the level that answered last (ist::BoundedOverlap), and whether it is within the accepted
	/// one. Not a number where no level is chosen.
	double acceptedError = 0, forceErrorBound = 0;
	bool withinTolerance = false;
	btISTQueryCost cost;      ///< since the pair began
	double savedSeconds = 0;  ///< steps without a query times the mean time of one, less what those steps took; needs measureQueryTime

	static const char* nameOf(Model model);
	static const char* nameOf(btISTStiffnessRule rule);
};

/// For each pair that the broad phase of a world has: which model answers, why, its expected error, its cost, and what it saved.
/// Offline: allocates; O(pairs log pairs). Between steps only.
struct btISTSceneReport
{
	/// What to call an object; may be empty: then bodies are numbered as they stand in the world.
	using Names = std::function<std::string(const btCollisionObject*)>;

	std::vector<btISTPairReport> pairs;
	btISTContactCache contactCache;
	double acceptedError = 0;  ///< force error, of all pairs that have none of their own; 0: the leaves answer always
	btISTQueryCost total;      ///< of all volumetric pairs, those that are gone among them
	double savedSeconds = 0;   ///< of the pairs above

	static btISTSceneReport of(btISTWorld& world, const Names& names = {});
	static btISTSceneReport of(const btCollisionWorld& world, btISTRegistration& registration, const Names& names = {});

	/// One line a pair, after one of the whole.
	std::vector<std::string> lines() const;
	std::string text() const;
	/// One object; not-finite numbers are null.
	/// {"schema":1, "economy", "kept_error", "accepted_error", "queries", "kept", "factor", "seconds", "query_seconds", "saved_seconds",
	/// "largest_kept_error", "pairs":[{"a", "b", "model", "level", "reason", "patches", "leaf_pairs", "force", "k", "stiffness_rule",
	/// "depth", "deepest", "expected_error", "accepted_error", "promised_error", "promise_kept", "queries", "kept", "node_visits",
	/// "ball_tests", "seconds", "query_seconds", "saved_seconds"}]}. Seconds are those of queries and of what was done instead;
	/// "promise_kept" is null where "promised_error" is.
	std::string json() const;

	/// Names of the bodies, as they are written.
	std::vector<std::string> namesA, namesB;
};
