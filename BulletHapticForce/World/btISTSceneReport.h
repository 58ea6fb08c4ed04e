// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Solver/btVolumetricStatistics.h"
#include "BulletHapticForce/World/btISTWarnings.h"

#include <functional>
#include <string>
#include <vector>

class btCollisionObject;
class btCollisionWorld;
class btISTWorld;

/// How the contact of one pair of shapes is computed. A pair of bodies has several of these when the bodies are compounds.
struct btISTPairReport
{
	enum Model
	{
		None,        ///< no contact is computed
		Stock,       ///< Bullet's own contact
		HalfSpace,   ///< surface or leaves against a plane
		ClosedForm,  ///< leaves against Bullet's box, sphere, capsule, cylinder or cone
		Trees        ///< leaves against leaves
	};

	const btCollisionObject *bodyA = nullptr, *bodyB = nullptr;
	Model model = None;
	std::string reason;  ///< why this model answers, and why the pair was queried or not in the last step
	int level = 0;       ///< level of the trees: 0 is the leaves; each further level has one body's balls reduced to a third
	int patches = 0;
	int64_t leafPairs = 0;
	double force = 0;  ///< force of the pressure, without damping and friction [N]
	double k = 0;      ///< stiffness in the last step [Pa/m]; 0 where the contact is not volumetric
	btISTStiffnessRule stiffnessRule = btISTStiffnessRule::Given;  ///< rule that decided `k`
	double depth = 0;                                              ///< depth of the deepest patch in the last step, volume over area [m]
	double depthShare = 0;                                         ///< `depth` as a share of the thinner body's thickness
	double load = 0;     ///< force that `k` carries at the depth at which the pair shall rest [N]; 0 where `k` was given
	double deepest = 0;  ///< largest depth since the pair began, as a share of the thinner body's thickness (btISTSubsteps::thickness)
	/// Expected error of the force as a share of the larger of the force and the force floor (btISTContactCache). It is the error bar of
	/// the query; when a cached result was used after motion, the granted error is added as the root of the sum of squares. Not a number
	/// where no error bar is known.
	double expectedError = 0;
	/// These three hold for two trees where a force error is accepted (btISTWorld::setForceError, setForceErrorOf). `acceptedError` is
	/// the error that is accepted for this pair. `forceErrorBound` is the error that 95 % of such contacts stay under at the level of the
	/// last answer (ist::BoundedOverlap). `withinTolerance` is true when the bound is at most the accepted error. The bound is not a
	/// number where no level is chosen.
	double acceptedError = 0, forceErrorBound = 0;
	bool withinTolerance = false;
	btISTQueryCost cost;  ///< cost since the pair began
	/// estimate: steps without a query times the mean time of a query, less the time of those steps; needs measureQueryTime
	double savedSeconds = 0;

	std::string advice;  ///< what to set where the contact is deep; empty elsewhere

	static const char* nameOf(Model model);
	static const char* nameOf(btISTStiffnessRule rule);
};

/// A kind of warning (btISTWarnings) that a world has given.
struct btISTWarningReport
{
	btISTWarning kind = btISTWarning::Deep;
	btISTWarnings::Record record;
	std::string nameA, nameB;  ///< of the worst contact, or of the last body; empty for none, and for a body that was removed since
	std::string advice;
};

/// Report of each pair in the broad phase of a world: which model answers and why, its expected error, its cost, and what the cache
/// saved. For offline use: it allocates and costs O(pairs log pairs). Call it between steps only.
struct btISTSceneReport
{
	/// Gives the name of an object. May be empty: bodies are then numbered in the order of the world.
	using Names = std::function<std::string(const btCollisionObject*)>;

	std::vector<btISTPairReport> pairs;
	btISTContactCache contactCache;
	double acceptedError = 0;                  ///< accepted force error of all pairs that have no own one; 0: the leaves answer always
	btISTQueryCost total;                      ///< cost of all volumetric pairs, including those that no longer exist
	double savedSeconds = 0;                   ///< sum over the pairs above
	std::vector<btISTWarningReport> warnings;  ///< of a btISTWorld: the kinds that occurred
	btVolumetricStatistics solver;             ///< of a btISTWorld

	static btISTSceneReport of(btISTWorld& world, const Names& names = {});
	static btISTSceneReport of(const btCollisionWorld& world, btISTRegistration& registration, const Names& names = {});

	/// One line about the queries of the whole world, one about its solver if it has solved anything, one for each warning, then one for
	/// each pair.
	std::vector<std::string> lines() const;
	std::string text() const;
	/// One object; numbers that are not finite are null.
	/// {"schema":1, "economy", "kept_error", "accepted_error", "queries", "kept", "factor", "seconds", "query_seconds", "saved_seconds",
	/// "largest_kept_error", "solver":{"islands", "islands_too_large", "friction_not_converged", "active_sets_not_found", "solved_again",
	/// "bodies_held"}, "warnings":[{"kind", "count", "a", "b", "k", "depth", "depth_share", "advice"}], "pairs":[{"a", "b", "model",
	/// "level", "reason", "patches", "leaf_pairs", "force", "k", "stiffness_rule", "depth", "depth_share", "deepest", "load", "advice",
	/// "expected_error", "accepted_error", "promised_error", "promise_kept", "queries", "kept", "node_visits", "ball_tests", "seconds",
	/// "query_seconds", "saved_seconds"}]}. "economy" is the contact cache, "kept" counts cached results, and "promised_error" is the error
	/// bound of the force. "seconds" is the time of the queries and of the cached results. "promise_kept" is null where "promised_error" is
	/// null.
	std::string json() const;

	/// Names of the bodies, as they are written in the report.
	std::vector<std::string> namesA, namesB;
};
