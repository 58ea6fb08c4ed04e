// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/QueryWorkspaceState.h"
#include "BulletISTCollision/Core/Query/VerletListState.h"

namespace ist
{
/// Limits of one traversal of two trees: its number of pairs, and the number of patches in its answer.
struct QueryLimits
{
	int64_t pairs = -1;  ///< largest number of pairs; negative: no limit
	int patches = 1;
};

/// One traversal of two trees. The pairs that it finds are summed at once, or listed first if they must be grouped or visited.
class TreeQuery
{
public:
	/// X: pose of B's tree frame in A's. All arguments outlive this object. With a Verlet list the number of pairs is not limited.
	TreeQuery(const BallTree& A, const BallTree& B, const Pose& X, QueryWorkspace::Implementation& work, const QueryOptions& options,
		const QueryLimits& limits, OverlapResult& result, VerletList::Implementation* list = nullptr);

	/// Returns false when the traversal reached the limit of pairs. The result then holds only the counts of the work done.
	bool run();

private:
	/// Computes the bounds and tolerances that a search needs for this pose. Returns false when the bounds of the bodies are apart.
	bool place();
	bool answer();
	/// Finds the pairs. Returns false when nothing is left to do: the bounds of the bodies are apart, or the Verlet list supplied the
	/// patches, too.
	bool find();
	kernels::PairSearch newSearch();
	void beginAtRoots(kernels::PairSearch& search) const;
	void count(const kernels::SearchCounts& counts);
	/// Fills the Verlet list with the pairs that come within `margin` at `around`. Returns false when that is not possible.
	bool fillAround(const Pose& around, double margin);
	/// Processes the pairs of the Verlet list as if a search had found them.
	void recall();
	/// Copies the next batch of remembered pairs, from `first` on, to where a search puts its pairs. Returns their number.
	int copyBatch(size_t first, size_t end);
	bool listHasPatches() const;
	/// Gives the whole answer in the remembered patches. If these no longer group the pairs that intersect, it drops them and returns
	/// false.
	bool reusePatches();
	/// Remembers the patches of the listed pairs.
	bool recordPatches(int groups);
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
	VerletList::Implementation* m_list;
	bool m_reusesList = false;          ///< whether the Verlet list is valid for this pose
	double m_lengthening = 1;           ///< upper bound of the factor by which the pose stretches B's lengths
	BoundingBall m_rootA{}, m_rootB{};  ///< bounds of the roots, in A's tree frame
	bool m_filled = false;              ///< whether the Verlet list was filled, with any margin
	bool m_onlyFills = false;           ///< whether this only fills the Verlet list and evaluates nothing
	float m_margin = 0;                 ///< margin with which the Verlet list is being filled [m]
	kernels::Terms m_terms;
	DampingWeights m_damping;
	bool m_grouped;
	kernels::PairBodies m_bodies;
	int m_listed = 0;
	kernels::PairSearch* m_search = nullptr;
	double m_sums[kernels::kSumCount] = {};
};
}  // namespace ist
