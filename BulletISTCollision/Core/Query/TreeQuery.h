// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/QueryMemory.h"
#include "BulletISTCollision/Core/Query/VerletListState.h"

namespace ist
{
/// What one look at two trees may cost, and in how many patches it may answer.
struct QueryLimits
{
	int64_t pairs = -1;  ///< negative: any number
	int patches = 1;
};

/// One look at two trees: what the search finds is either summed at once, or listed first, to be grouped or visited.
class TreeQuery
{
public:
	/// X: pose of B's tree frame in A's. All arguments outlive this. With a memory the number of pairs is not limited.
	TreeQuery(const BallTree& A, const BallTree& B, const Pose& X, QueryWorkspace::Implementation& work, const QueryOptions& options,
		const QueryLimits& limits, OverlapResult& result, VerletList::Implementation* memory = nullptr);

	/// False when the limit was met: the result then holds nothing but the work done.
	bool run();

private:
	/// Sets what a search needs to know of the pose. False when the bodies' bounds are apart.
	bool place();
	bool answer();
	/// False when there is nothing left to do: the bodies' bounds are apart, or the memory had the patches, too.
	bool find();
	kernels::PairSearch newSearch();
	void beginAtRoots(kernels::PairSearch& search) const;
	void count(const kernels::SearchCounts& counts);
	/// Fills the memory with what comes within `margin` at `around`. False where it could not.
	bool fillAround(const Pose& around, double margin);
	/// What the memory holds, as if it had been searched for.
	void recall();
	/// The next of the remembered pairs from `first` on, as if the search had found them; returns how many.
	int recallBatch(size_t first, size_t end);
	bool remembersPatches() const;
	/// The whole answer, in the patches that the memory has. False, and the memory has none any more, where these are no grouping of what
	/// intersects now.
	bool recallPatches();
	/// Remembers the patches of the pairs that were listed.
	bool rememberPatches(int groups);
	int cull(int count, float margin);
	bool hasShapes() const { return m_options.model != Model::Inner; }
	static void take(void* query, int count) { static_cast<TreeQuery*>(query)->take(count); }
	void take(int count);
	void publishPatches(int groups);
	void publishWhole();
	void publishSums(int patches);
	void publishPairs();
	void evaluate(uint32_t* a, uint32_t* b, int count, double* sums) const;

	const BallTree& m_A;
	const BallTree& m_B;
	const Pose& m_X;
	QueryWorkspace::Implementation& m_work;
	const QueryOptions& m_options;
	const QueryLimits& m_limits;
	OverlapResult& m_result;
	VerletList::Implementation* m_memory;
	bool m_remembered = false;          ///< the memory holds for this pose
	double m_lengthening = 1;           ///< of B by its pose, at most
	BoundingBall m_rootA{}, m_rootB{};  ///< in A's tree frame
	bool m_filled = false;              ///< the memory, with whatever the margin allowed
	bool m_onlyFills = false;           ///< and evaluates nothing
	float m_margin = 0;                 ///< with which the memory is being filled [m]
	kernels::Terms m_terms;
	DampingWeights m_damping;
	bool m_grouped;
	kernels::PairBodies m_bodies;
	int m_listed = 0;
	kernels::PairSearch* m_search = nullptr;
	double m_sums[kernels::kSumCount] = {};
};
}  // namespace ist
