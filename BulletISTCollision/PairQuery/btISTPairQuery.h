// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactCache.h"
#include "BulletISTCollision/Contact/btISTContactStore.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Registry/btISTShapeField.h"

#include <optional>
#include <utility>
#include <vector>

/// How the pairs of a world are asked: the same for all of them within a step. Not installed.
class btISTQueryRules
{
public:
	btISTContactCache contactCache;

	const ist::QueryOptions& options() const { return m_options; }
	/// Accepted of all pairs but those of bodies that have one of their own; 0: the leaves answer.
	double forceError() const { return m_forceError; }
	/// Accepted of a pair. O(bodies that have one of their own).
	double forceErrorOf(const btCollisionObject* a, const btCollisionObject* b) const;
	/// Another one after every change but of the contact cache: no result of the former ones is kept.
	uint64_t version() const { return m_version; }
	void set(const ist::QueryOptions& options, double forceError);
	/// Without a share, as all others again.
	void setForceErrorOf(const btCollisionObject* body, std::optional<double> share);

private:
	ist::QueryOptions m_options;
	double m_forceError = 0;
	std::vector<std::pair<const btCollisionObject*, double>> m_errorsOfBodies;
	uint64_t m_version = 0;
};

/// What an answer took. Not installed.
struct btISTQueryWork
{
	bool asked = false;         ///< false: the sums were kept
	ist::OverlapResult result;  ///< when asked: its counts; its patches are not to be used
	double seconds = 0;         ///< when timed
};

/// The sums of one contact at its X_AB, kept or asked for. Reads and writes nothing but the contact and the workspace, so that several can
/// be answered side by side, each with a workspace of its own. Allocates on the first query with larger trees, never after. Not installed.
class btISTPairQuery
{
public:
	/// `field`: B's shape where it has no tree. `responds`: the contact remembers from step to step. `damping`: sums are to have theirs,
	/// where the pair has a dissipation. All outlive this.
	btISTPairQuery(const btISTShapeField& field, const btISTQueryRules& rules, bool responds, bool damping)
		: m_field(field),
		  m_rules(rules),
		  m_responds(responds),
		  m_damping(damping)
	{}
	btISTQueryWork answer(btISTContact& contact, ist::QueryWorkspace& workspace, bool timed) const;
	/// All that `answer` may have written. What else a contact has is its owner's, who may have gone on since.
	static void copyAnswer(const btISTContact& from, btISTContact& to);
	/// Whether the sums were asked for with other weights than the pair has now.
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
