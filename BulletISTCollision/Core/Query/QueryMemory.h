// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/DemandZeroArray.h"
#include "BulletISTCollision/Core/Geometry/FieldTerm.h"
#include "BulletISTCollision/Core/Query/ContactPatches.h"
#include "BulletISTCollision/Core/Query/Kernels/QueryKernel.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"

#include <vector>

namespace ist
{
/// The tree of a body that speaks for it in a model.
inline const BallTree& treeOf(const InnerSphereTree& body, Model model)
{
	return model == Model::Law ? body.law : model == Model::Cell ? body.cells : body.inner;
}

/// False for an empty tree, and for one of the other kind.
inline bool answers(const BallTree& tree, Model model) { return !tree.empty() && tree.ellipsoids.empty() == (model == Model::Inner); }

/// What grows with the trees of a query. An entry holds for the query that has its number (`QueryWorkspace::Implementation::epoch`) only.
struct TreeRoom
{
	std::vector<kernels::BlockColumns> columnsA, moved;
	std::vector<uint32_t> epochsA;
	std::vector<kernels::BlockMark> marks;
	std::vector<kernels::MovedCenter> movedCenters;
	std::vector<MomentEllipsoid> movedBalls;

	/// Of A, of B, and those of B that have an ellipsoid.
	void reserveSlots(size_t slotsA, size_t slotsB, size_t ellipsoidsB);
	/// Column by column the larger of both.
	void takeLarger(TreeRoom& other) noexcept;
};

struct QueryBuffers::Implementation : TreeRoom
{
	PatchGrouper::BallRoom balls;
	bool taken = false;  ///< what is here has numbers of another workspace
};

/// What QueryWorkspace owns.
struct QueryWorkspace::Implementation : TreeRoom
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
	std::vector<OverlapPair> pairs, keptPairs;  ///< of the last look, of one that may still be wanted
	std::vector<FieldTerm> terms;               ///< against an analytic field, in the order of `stream`; never more than it has room for
	PatchGrouper grouper;
	std::vector<OverlapIntegrals> patches, keptPatches;

	Implementation(const QueryCapacity& wanted, const kernels::QueryKernel* chosen);
	/// Grows what depends on the size of the trees. Allocates on the first query with a larger tree, never after.
	void reserveFor(const BallTree& A, const BallTree& B);
	/// An empty list of terms, and room for grouping. Allocates on the first query with a larger tree, never after.
	void reserveTerms(const BallTree& A);
	/// Makes the lists of pairs of leaves resident.
	void makeResident();
	/// Room for the visitors' list. Allocates on the first query that wants it.
	void reservePairs();
};
}  // namespace ist
