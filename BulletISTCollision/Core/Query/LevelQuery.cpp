// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/LevelQuery.h"

#include "BulletISTCollision/Core/Base/SmoothStep.h"

#include <algorithm>
#include <cmath>

namespace ist
{
namespace
{
/// Ratio of the pairs of a level to those of the next coarser one: its usual value and its smallest one.
constexpr double kUsualStep = 2.2, kLeastStep = 1.25;
/// A level fades out while its pairs plus those of the next coarser level grow from this share of the budget to all of it. When
/// the finer level is gone, the coarser one must not fade yet, or the answer would jump. That holds if each level has more than
/// 1 / kFadeBegin times as many pairs as the next coarser one.
constexpr double kFadeBegin = 0.8;

int patchCapacity(const QueryWorkspace::Implementation& work, const QueryOptions& options)
{
	return options.patches ? work.capacity.patches : 1;
}

/// Mixes `share` of `fine`, whose patches are `patches`, with (1 - share) of `coarse`. The patches of both stay side by side where
/// there is room.
void fade(OverlapResult& fine, const OverlapResult& coarse, double share, OverlapIntegrals* patches, int capacity)
{
	const auto mixed = [&](const OverlapIntegrals& f, const OverlapIntegrals& c) {
		OverlapIntegrals sum = f, rest = c;
		sum.scale(share);
		rest.scale(1 - share);
		sum.add(rest);
		return sum;
	};
	fine.patches = patches;  // a finer level whose bodies are apart has no patches
	fine.total = mixed(fine.total, coarse.total);
	fine.levelShare = share;
	fine.otherLevel = coarse.level;
	if (fine.patchCount + coarse.patchCount > capacity)
	{
		patches[0] = fine.total;
		fine.patchCount = fine.total.pairs > 0 ? 1 : 0;
		return;
	}
	for (int p = 0; p < fine.patchCount; ++p) patches[p].scale(share);
	for (int p = 0; p < coarse.patchCount; ++p)
	{
		OverlapIntegrals& patch = patches[fine.patchCount++] = coarse.patches[p];
		patch.scale(1 - share);
	}
}

/// One query within a budget.
class BudgetedQuery
{
public:
	BudgetedQuery(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X, QueryWorkspace::Implementation& work,
		const QueryOptions& options, int finest, int64_t capacity)
		: m_A(A),
		  m_B(B),
		  m_X(X),
		  m_work(work),
		  m_options(options),
		  m_finest(finest),
		  m_pairs(options.maxPairs >= 0 ? std::min(capacity, options.maxPairs) : capacity)
	{
		// Memory is reserved at once, so that a finer level does not allocate in a later query.
		work.reserveFor(A.law, B.law);
		m_patches = options.blend ? std::max(1, work.capacity.patches / 2) : work.capacity.patches;
	}

	OverlapResult run();

private:
	/// Queries one level. Returns false when it meets the limit; `result` then holds only the counts of the work done.
	bool queryLevel(int level, OverlapResult& result);
	/// Saves the patches and pairs of the last traversal from being overwritten by later ones.
	void save()
	{
		std::swap(m_work.patches, m_work.savedPatches);
		std::swap(m_work.pairs, m_work.savedPairs);
	}
	/// Whether the search for a finer level may end.
	bool isEnough(int64_t pairs) const { return double(pairs) * (m_options.blend ? 2 : kLeastStep) > double(m_pairs); }
	void fadeOut(OverlapResult& best, int coarsest);

	const InnerSphereTree& m_A;
	const InnerSphereTree& m_B;
	const Pose& m_X;
	QueryWorkspace::Implementation& m_work;
	const QueryOptions& m_options;
	int m_finest;
	int64_t m_pairs;
	int m_patches;
	int64_t m_nodeVisits = 0, m_blockPairs = 0, m_ballTests = 0;
};

bool BudgetedQuery::queryLevel(int level, OverlapResult& result)
{
	const bool fits = ist::queryLevel(m_A, m_B, m_X, m_work, m_options, level, {m_pairs, m_patches}, result);
	m_nodeVisits += result.nodeVisits;
	m_blockPairs += result.blockPairs;
	m_ballTests += result.ballTests;
	return fits;
}

OverlapResult BudgetedQuery::run()
{
	const int coarsest = std::max(m_finest, levelCount(m_A, m_B));
	OverlapResult best, next;
	// Surfaces are the most accurate, and they often cost less than any level, so they are asked first.
	const bool asksSurfaces = answerSurfaces(m_A, m_B, m_options, m_finest);
	double ofSurfaces = 0;
	if (asksSurfaces && queryLevel(m_finest, best))
	{
		ofSurfaces = m_options.blend && coarsest > 0 ? (1 - double(costInPairs(best.total)) / double(m_pairs)) / (1 - kFadeBegin) : 1;
		if (ofSurfaces >= 1) return best;
	}
	if (asksSurfaces && coarsest > 0) m_finest = 1;
	if (!queryLevel(coarsest, best))
	{
		best.status = QueryStatus::BudgetTooSmall;
		return best;
	}
	save();
	const double usual = m_options.blend ? double(m_pairs) / (1 + 1 / kUsualStep) : double(m_pairs);
	for (int exceeded = m_finest - 1; best.level > exceeded + 1 && !isEnough(best.total.pairs);)
	{
		const double growth = std::max(1.0, usual / double(std::max<int64_t>(best.total.pairs, 1)));
		const int leap = std::max(1, int(std::log(growth) / std::log(kUsualStep)));
		const int level = std::max(exceeded + 1, best.level - leap);
		if (queryLevel(level, next))
		{
			best = next;
			save();
		}
		else exceeded = level;
	}
	if (m_options.blend) fadeOut(best, coarsest);
	if (best.patches != m_work.patches.data()) save();
	best.coarsened = asksSurfaces || best.level > m_finest || best.levelShare < 1;
	if (ofSurfaces > 0)
	{
		save();
		if (!queryLevel(0, next)) return best;
		fade(next, best, smoothStep(ofSurfaces), m_work.patches.data(), patchCapacity(m_work, m_options));
		next.coarsened = true;
		best = next;
	}
	best.nodeVisits = m_nodeVisits;
	best.blockPairs = m_blockPairs;
	best.ballTests = m_ballTests;
	return best;
}

void BudgetedQuery::fadeOut(OverlapResult& best, int coarsest)
{
	OverlapResult coarse;
	// A coarser level has no more pairs than this one.
	while (best.level < coarsest && 2 * double(best.total.pairs) > kFadeBegin * double(m_pairs))
	{
		if (!queryLevel(best.level + 1, coarse)) return;
		const double fill = double(best.total.pairs + coarse.total.pairs) / double(m_pairs), t = (1 - fill) / (1 - kFadeBegin);
		if (t >= 1) return;
		if (t > 0) return fade(best, coarse, smoothStep(t), m_work.savedPatches.data(), patchCapacity(m_work, m_options));
		best = coarse;
		save();
	}
}
}  // namespace

bool answerSurfaces(const InnerSphereTree& A, const InnerSphereTree& B, const QueryOptions& options, int level)
{
	return wantSurfaces(options, level) && !A.surface.empty() && !B.surface.empty();
}

bool wantSurfaces(const QueryOptions& options, int level)
{
	return options.model == Model::Law && level <= 0 && !options.sortPairs && !options.listMeetingBounds;
}

SurfaceAnswer querySurfaces(const BodySurface& A, const BodySurface& B, const Pose& X, QueryWorkspace::Implementation& work,
	const QueryOptions& options, const QueryLimits& limits, OverlapResult& result)
{
	const int most = options.patches ? limits.patches : 1;
	const int64_t mostFaces = limits.pairs < 0 ? -1 : limits.pairs / kPairsPerFace;
	const SurfaceOverlap found = surfaceOverlap(A, B, X, *work.surfaces, options.damping, most, mostFaces);
	result.nodeVisits = found.counts.nodes;
	result.ballTests = found.counts.planes;
	if (found.isOverLimit) return SurfaceAnswer::OverLimit;
	if (found.dropped > 0) return SurfaceAnswer::Incomplete;
	result.total = found.total;
	result.patchCount = found.patchCount;
	result.patches = work.patches.data();
	result.facesA = found.ofA;
	result.facesB = found.ofB;
	result.faceCountA = found.countA;
	result.faceCountB = found.countB;
	result.leanOnA = found.leanOnA;
	result.leanOnB = found.leanOnB;
	std::copy_n(found.patches, size_t(found.patchCount), work.patches.begin());
	const auto clear = [](OverlapIntegrals& sums) { sums.stiffnessA = sums.stiffnessB = {}; };
	if (options.stiffness) return SurfaceAnswer::Good;
	clear(result.total);
	for (int p = 0; p < result.patchCount; ++p) clear(work.patches[size_t(p)]);
	return SurfaceAnswer::Good;
}

bool queryLevel(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X, QueryWorkspace::Implementation& work,
	const QueryOptions& options, int level, const QueryLimits& limits, OverlapResult& result, VerletList::Implementation* list)
{
	result = {};
	result.level = level;
	if (answerSurfaces(A, B, options, level))
	{
		result.ballsA = &A.law;
		result.ballsB = &B.law;
		const SurfaceAnswer answer = querySurfaces(A.surface, B.surface, X, work, options, limits, result);
		if (answer != SurfaceAnswer::Incomplete) return answer == SurfaceAnswer::Good;
		// The sums of leaves are right however many pairs there are.
	}
	const LevelPair trees = isOfLeaves(options.model) ? levelOf(A, B, level)
													  : LevelPair{&treeOf(A, options.model), &treeOf(B, options.model), 0, 0};
	work.reserveFor(*trees.treeA, *trees.treeB);
	return TreeQuery(*trees.treeA, *trees.treeB, X, work, options, limits, result, list).run();
}

OverlapResult queryWithin(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X, QueryWorkspace::Implementation& work,
	const QueryOptions& options, int finest, int64_t capacity)
{
	return BudgetedQuery(A, B, X, work, options, finest, capacity).run();
}

namespace
{
/// Largest number of patches of each of two levels such that the patches of both fit.
int halfOfPatchCapacity(const QueryWorkspace::Implementation& work, const QueryOptions& options)
{
	return std::max(1, patchCapacity(work, options) / 2);
}
}  // namespace

LevelAnswers queryBothLevels(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X, QueryWorkspace::Implementation& work,
	const QueryOptions& options, int level, int otherLevel, const OverlapResult* known)
{
	const int most = halfOfPatchCapacity(work, options);
	work.reserveFor(A.law, B.law);
	const auto query = [&](int of) {
		OverlapResult result;
		queryLevel(A, B, X, work, options, of, {-1, most}, result);
		return result;
	};
	// The known answer may have been grouped with a larger limit. If it has at most `most` patches, that limit would give the same ones.
	const bool isUsable = known && !known->coarsened && known->pairListComplete && known->patchCount <= most;
	const auto isKnown = [&](int of) { return isUsable && known->level == of; };
	LevelAnswers answers;
	if (isKnown(otherLevel) && !isKnown(level))
	{
		answers.other = *known;
		std::swap(work.patches, work.savedPatches);
		answers.first = query(level);
	}
	else
	{
		answers.first = isKnown(level) ? *known : query(level);
		std::swap(work.patches, work.savedPatches);
		answers.other = query(otherLevel);
		std::swap(work.patches, work.savedPatches);
	}
	const bool isGroupedAlike = most == patchCapacity(work, options) || answers.first.patchCount < most;
	answers.firstIsWhole = isKnown(level) || (answers.first.pairListComplete && isGroupedAlike);
	return answers;
}

OverlapResult mixLevels(const LevelAnswers& answers, double otherShare, QueryWorkspace::Implementation& work, const QueryOptions& options)
{
	OverlapResult result = answers.first;
	const OverlapResult& other = answers.other;
	fade(result, other, 1 - otherShare, work.patches.data(), patchCapacity(work, options));
	result.nodeVisits += other.nodeVisits;
	result.blockPairs += other.blockPairs;
	result.ballTests += other.ballTests;
	return result;
}

OverlapResult queryTwoLevels(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X, QueryWorkspace::Implementation& work,
	const QueryOptions& options, int level)
{
	return mixLevels(queryBothLevels(A, B, X, work, options, level, options.otherLevel), options.otherShare, work, options);
}
}  // namespace ist
