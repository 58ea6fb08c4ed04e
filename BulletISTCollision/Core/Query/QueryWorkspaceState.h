// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/DemandZeroArray.h"
#include "BulletISTCollision/Core/Geometry/FieldTerm.h"
#include "BulletISTCollision/Core/Query/ContactPatches.h"
#include "BulletISTCollision/Core/Query/Kernels/QueryKernel.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Query/PlanarBody.h"
#include "BulletISTCollision/Core/Query/SurfaceOverlap.h"

#include <vector>

namespace ist
{
inline bool isOfLeaves(Model model) { return model == Model::Law || model == Model::Leaf; }

/// The tree of balls that represents a body in a model.
inline const BallTree& treeOf(const InnerSphereTree& body, Model model)
{
	return isOfLeaves(model) ? body.law : model == Model::Cell ? body.cells : body.inner;
}

/// Whether the tree can answer for the model. Returns false for an empty tree, and for a tree of balls where ellipsoids are needed or
/// the reverse.
inline bool answers(const BallTree& tree, Model model) { return !tree.empty() && tree.ellipsoids.empty() == (model == Model::Inner); }

/// Memory that grows with the trees of a query. An entry is valid only for the query whose number it carries
/// (`QueryWorkspace::Implementation::epoch`).
struct TreeArrays
{
	std::vector<kernels::BlockColumns> columnsA, moved;
	std::vector<uint32_t> epochsA;
	std::vector<kernels::BlockMark> marks;
	std::vector<kernels::MovedCenter> movedCenters;
	std::vector<MomentEllipsoid> movedBalls;

	/// Grows the arrays to these numbers of slots and ellipsoids.
	void reserveSlots(size_t slotsA, size_t slotsB, size_t ellipsoidsB);
	/// Swaps in each array of `other` that is larger.
	void takeLarger(TreeArrays& other) noexcept;
};

struct QueryBuffers::Implementation : TreeArrays
{
	PatchGrouper::BallArrays balls;
	bool taken = false;  ///< whether a workspace has taken these buffers, whose entries now carry that workspace's epochs
};

/// Memory that QueryWorkspace owns.
struct QueryWorkspace::Implementation : TreeArrays
{
	const kernels::QueryKernel* kernel = nullptr;  ///< null: the wanted instruction set cannot run here
	QueryCapacity capacity;

	DemandZeroArray<uint32_t> indices;  ///< columns of the lists below
	DemandZeroArray<float> numbers;
	kernels::SubtreeList openA{}, openB{}, leaves{};
	int openBatch = 1;
	uint32_t *ballOf = nullptr, *blockOf = nullptr, *pairA = nullptr, *pairB = nullptr;
	uint32_t epoch = 0;

	kernels::PairStream stream{};  ///< intersecting pairs, in the order in which they were found
	std::vector<uint64_t> keys;
	std::vector<OverlapPair> pairs, savedPairs;  ///< pairs of the last traversal, and of an earlier one that may still be the answer
	std::vector<FieldTerm> terms;  ///< terms against an analytic field, in the order of `stream`; never more than its capacity
	PatchGrouper grouper;
	std::vector<OverlapIntegrals> patches, savedPatches;
	std::unique_ptr<SurfaceWorkspace> surfaces;
	PlanarBody planar;  ///< half-space or box of the last query against one, laid out for that query's pose

	Implementation(const QueryCapacity& wanted, const kernels::QueryKernel* chosen);
	/// Grows the arrays that depend on the size of the trees. Only the first query with a larger tree allocates.
	void reserveFor(const BallTree& A, const BallTree& B);
	/// Empties the list of terms and reserves memory for grouping. Only the first query with a larger tree allocates.
	void reserveTerms(const BallTree& A);
	/// Makes the lists of pairs of leaves resident.
	void makeResident();
	/// Reserves the list of pairs for callers (`QueryOptions::sortPairs`). Only the first query that needs it allocates.
	void reservePairs();
};
}  // namespace ist
