// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactCache.h"
#include "BulletISTCollision/Contact/btISTContactStore.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Registry/btISTShapeField.h"

#include <optional>
#include <utility>
#include <vector>

/// Settings of the queries of a world, equal for all pairs within a step. Not installed.
class btISTQueryRules
{
public:
	btISTContactCache contactCache;

	const ist::QueryOptions& options() const { return m_options; }
	/// Force tolerance of all pairs except those of bodies with a tolerance of their own; 0: the leaves answer.
	double forceError() const { return m_forceError; }
	/// Force tolerance of a pair. O(bodies with a tolerance of their own).
	double forceErrorOf(const btCollisionObject* a, const btCollisionObject* b) const;
	/// Number that changes with every setting except the contact cache. Cached results of a former version are not reused.
	uint64_t version() const { return m_version; }
	void set(const ist::QueryOptions& options, double forceError);
	/// Sets the force tolerance of a body; without a share the body is treated as all others again.
	void setForceErrorOf(const btCollisionObject* body, std::optional<double> share);

private:
	ist::QueryOptions m_options;
	double m_forceError = 0;
	std::vector<std::pair<const btCollisionObject*, double>> m_errorsOfBodies;
	uint64_t m_version = 0;
};

/// Result and cost of one answer. Not installed.
struct btISTQueryWork
{
	bool asked = false;         ///< false: the cached result was reused
	ist::OverlapResult result;  ///< counts of the query, if asked; the patches are not valid
	double seconds = 0;         ///< time of the answer, if timed [s]
};

/// Computes the sums of one contact at its X_AB, by a query or from the cached result. It reads and writes only the contact and the
/// workspace, so several contacts can be computed in parallel, each with its own workspace. It allocates only on the first query with
/// larger trees. Not installed.
class btISTPairQuery
{
public:
	/// `field`: B's shape if B has no tree. `responds`: the contact keeps state from step to step. `damping`: the sums include damping if
	/// the pair has a dissipation. `field` and `rules` must outlive this object.
	btISTPairQuery(const btISTShapeField& field, const btISTQueryRules& rules, bool responds, bool damping)
		: m_field(field),
		  m_rules(rules),
		  m_responds(responds),
		  m_damping(damping)
	{}
	btISTQueryWork answer(btISTContact& contact, ist::QueryWorkspace& workspace, bool timed) const;
	/// Replaces the sums of the contact by those of a query at its X_AB, whatever was cached. The cached result stays as it is.
	void queryAt(btISTContact& contact, ist::QueryWorkspace& workspace) const { take(contact, ask(contact, workspace)); }
	/// Lower bound of the clearance at the contact's X_AB [m]; 0 if none is known.
	double clearanceAt(const btISTContact& contact) const;
	/// Copies all that `answer` may have written. The other members belong to the contact's owner, who may have changed them since.
	static void copyAnswer(const btISTContact& from, btISTContact& to);
	/// Writes the error of the sums with the present constants.
	static void judge(btISTContact& contact);
	/// Whether the sums were computed with other weights than the pair has now.
	bool lacksDamping(const btISTContact& contact) const;

private:
	ist::DampingWeights dampingWeights(const btISTContact& contact) const;
	ist::OverlapResult askTrees(btISTContact& contact, ist::QueryWorkspace& workspace, const ist::QueryOptions& options) const;
	ist::OverlapResult ask(btISTContact& contact, ist::QueryWorkspace& workspace) const;
	void take(btISTContact& contact, const ist::OverlapResult& result) const;
	btISTCachedResult::Measures measures(const btISTContact& contact) const;
	double clearance(const ist::OverlapResult& result, btISTContact& contact) const;

	const btISTShapeField& m_field;
	const btISTQueryRules& m_rules;
	bool m_responds, m_damping;
};
