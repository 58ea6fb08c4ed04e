// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/PairQuery/btISTPairQuery.h"

#include "BulletISTCollision/Core/Base/SteadyTime.h"
#include "BulletISTCollision/Core/Query/LeafClearance.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"
#include "BulletISTCollision/PairQuery/btISTVerletLists.h"

#include <algorithm>
#include <cmath>
#include <limits>

double btISTQueryRules::forceErrorOf(const btCollisionObject* a, const btCollisionObject* b) const
{
	double own = std::numeric_limits<double>::infinity();
	for (const auto& [body, share] : m_errorsOfBodies)
		if (body == a || body == b) own = std::min(own, share);
	return std::isfinite(own) ? own : m_forceError;
}

void btISTQueryRules::set(const ist::QueryOptions& options, double forceError)
{
	m_options = options;
	m_forceError = forceError;
	++m_version;
}

void btISTQueryRules::setForceErrorOf(const btCollisionObject* body, std::optional<double> share)
{
	const auto isIt = [body](const auto& entry) { return entry.first == body; };
	m_errorsOfBodies.erase(std::remove_if(m_errorsOfBodies.begin(), m_errorsOfBodies.end(), isIt), m_errorsOfBodies.end());
	if (share) m_errorsOfBodies.emplace_back(body, *share);
	++m_version;
}

/// Weights of the damping that the sums of `contact` should include; both zero: no damping.
ist::DampingWeights btISTPairQuery::dampingWeights(const btISTContact& contact) const
{
	const bool wanted = m_damping && contact.constants.dissipation > 0;
	return wanted ? ist::DampingWeights{contact.constants.weightA, contact.constants.weightB} : ist::DampingWeights();
}

bool btISTPairQuery::lacksDamping(const btISTContact& contact) const
{
	const ist::DampingWeights wanted = dampingWeights(contact);
	return contact.patchCount > 0 && wanted != ist::DampingWeights() && wanted != contact.total.dampingWeights;
}

ist::OverlapResult btISTPairQuery::askTrees(btISTContact& contact, ist::QueryWorkspace& workspace, const ist::QueryOptions& options) const
{
	ist::AdaptiveLevel& pair = contact.accuracy;
	const double error = m_rules.forceErrorOf(contact.bodyA, contact.bodyB);
	const btISTVerletList::Loan memory(contact.memory.get());
	if (!(error > 0) && pair.level <= 0 && pair.fadedShare == 0)
	{
		pair = ist::AdaptiveLevel();
		return ist::queryOverlap(*contact.treeA, *contact.treeB, contact.X_AB, workspace, options, memory.get());
	}
	// The force of the leaves fades out, too, when a coarser level takes over.
	if (pair.level < 0 && contact.patchCount > 0 && contact.level == 0) pair.level = 0;
	ist::ForceTolerance accepted;
	accepted.error = error;
	accepted.weightA = contact.constants.weightA;  // weight of the last step
	accepted.weightB = contact.constants.weightB;
	const ist::OverlapResult result = ist::queryAdaptive(
		*contact.treeA, *contact.treeB, contact.X_AB, workspace, accepted, options, pair, memory.get());
	if (!(error > 0) && pair.level <= 0 && pair.fadedShare == 0) pair = ist::AdaptiveLevel();
	return result;
}

ist::OverlapResult btISTPairQuery::ask(btISTContact& contact, ist::QueryWorkspace& workspace) const
{
	ist::QueryOptions options = m_rules.options();
	options.damping = dampingWeights(contact);
	if (contact.treeB)
	{
		const ist::OverlapResult result = askTrees(contact, workspace, options);
		if (result.status != ist::QueryStatus::BudgetTooSmall) return result;
		// Without an answer the bodies would pass through each other, so the coarsest level answers.
		options.level = ist::levelCount(*contact.treeA, *contact.treeB);
	}
	options.maxPairs = -1;
	options.blend = false;
	if (contact.treeB) return ist::queryOverlap(*contact.treeA, *contact.treeB, contact.X_AB, workspace, options);
	contact.accuracy = ist::AdaptiveLevel();
	contact.halfSpace = m_field.isHalfSpace();
	ist::OverlapResult none;
	none.status = ist::QueryStatus::InvalidPose;
	if (!m_field.field()) return none;  // the shape was scaled to nothing since the pair was made
	contact.volumeB = m_field.field()->volume();
	return ist::queryField(*contact.treeA, *m_field.field(), contact.X_AB * m_field.X_SF(), workspace, options);
}

/// Clearance of the leaves. Zero if there is none, if a query is as cheap, or if a coarser level answered, whose balls reach farther.
double btISTPairQuery::clearance(const ist::OverlapResult& result, btISTContact& contact) const
{
	if (result.level > 0) return 0;
	if (result.status != ist::QueryStatus::Ok || result.total.pairs > 0 || result.nodeVisits == 0 || !contact.kept.wantsClearance())
		return 0;
	return clearanceAt(contact);
}

double btISTPairQuery::clearanceAt(const btISTContact& contact) const
{
	constexpr int kMostOpened = 12;
	if (contact.treeB) return ist::leafClearance(*contact.treeA, *contact.treeB, contact.X_AB, kMostOpened);
	if (!m_field.field()) return 0;
	return ist::leafClearance(*contact.treeA, *m_field.field(), contact.X_AB * m_field.X_SF(), kMostOpened);
}

btISTCachedResult::Measures btISTPairQuery::measures(const btISTContact& contact) const
{
	if (!contact.treeB) return m_field.measures();
	return {m_rules.forceErrorOf(contact.bodyA, contact.bodyB) > 0 ? contact.constants.weightA : 0};
}

void btISTPairQuery::take(btISTContact& contact, const ist::OverlapResult& result) const
{
	contact.status = result.status;
	contact.level = result.level;
	contact.leafDensity = contact.treeB ? ist::leafDensity(result, *contact.treeA, *contact.treeB) : ist::leafDensity(*contact.treeA);
	// Bodies that only graze may have patches without volume: those press on nothing.
	const bool overlap = result.status == ist::QueryStatus::Ok && result.total.volume > 0;
	contact.total = overlap ? result.total : ist::OverlapIntegrals();
	contact.patchCount = overlap ? std::min(result.patchCount, btISTContact::kMaxPatches) : 0;
	std::copy(result.patches, result.patches + contact.patchCount, contact.patches);
}

btISTQueryWork btISTPairQuery::answer(btISTContact& contact, ist::QueryWorkspace& workspace, bool timed) const
{
	const double begin = timed ? ist::steadyMicroseconds() : 0;
	btISTQueryWork work;
	if (contact.ahead > 0)
	{
		// The sums are those of a later pose.
		contact.ahead = 0;
		contact.patchCount = 0;
		contact.total = ist::OverlapIntegrals();
	}
	const btISTCachedResult::Measures on = measures(contact);
	const bool fading = contact.accuracy.fadedShare > 0;  // fading from one level into another
	const int before = contact.accuracy.level;
	contact.use = m_responds && !fading ? contact.kept.use(contact, on, m_rules.version(), m_rules.contactCache) : btISTCachedResult::Ask;
	work.asked = contact.use == btISTCachedResult::Ask;
	if (work.asked)
	{
		work.result = ask(contact, workspace);
		take(contact, work.result);
	}
	if (work.asked && m_responds)
	{
		// While the level changes, the next query at the same pose may give another result.
		const bool settled = !fading && contact.accuracy.fadedShare == 0 && contact.accuracy.level == before;
		if (m_rules.contactCache.on && settled)
			contact.kept.keep(contact, on, m_rules.version(), clearance(work.result, contact), m_rules.contactCache);
		else contact.kept.forget();
	}
	if (timed) work.seconds = 1e-6 * (ist::steadyMicroseconds() - begin);
	return work;
}

void btISTPairQuery::judge(btISTContact& contact)
{
	contact.error = ist::OverlapError();
	if (!(contact.total.volume > 0)) return;
	const double gaps = contact.treeA->errorLength() + (contact.treeB ? contact.treeB->errorLength() : 0);
	contact.error = ist::overlapError(contact.total, gaps, contact.leafDensity, contact.constants.k);
}

void btISTPairQuery::copyAnswer(const btISTContact& from, btISTContact& to)
{
	to.status = from.status;
	to.level = from.level;
	to.leafDensity = from.leafDensity;
	to.total = from.total;
	to.patchCount = from.patchCount;
	std::copy(from.patches, from.patches + from.patchCount, to.patches);
	to.ahead = from.ahead;
	to.accuracy = from.accuracy;
	to.halfSpace = from.halfSpace;
	to.volumeB = from.volumeB;
	to.use = from.use;
	to.kept = from.kept;
}
