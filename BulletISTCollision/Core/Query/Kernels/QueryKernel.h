// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/Kernels/FaceSearch.h"
#include "BulletISTCollision/Core/Tree/BallTree.h"
#include "BulletISTCollision/Core/Tree/TreeLimits.h"

#include <cstddef>
#include <cstdint>

// Interface between the query's driver and its kernels. This header is compiled for several instruction sets, and the linker would merge
// a function that two of them define. So it holds only plain structs and raw pointers.
namespace ist::kernels
{
/// The balls of a block as columns, for the distance tests. `reach`: the radius; for blocks of B it includes the slack.
struct alignas(64) BlockColumns
{
	float x[kBlockWidth], y[kBlockWidth], z[kBlockWidth], reach[kBlockWidth];
};

/// Epoch in which a block of B was last moved to A's frame, and its number of balls without padding.
struct BlockMark
{
	uint32_t epoch, count;
};

/// Centre of a ball of B in A's tree frame, not rounded to floats, and its radius.
struct alignas(32) MovedCenter
{
	double x, y, z, R;
};

/// Number of spare entries that a list of vectors needs behind its end, because stores are always whole vectors.
constexpr int kListSlack = 16;
/// Largest number of entries that one level of the descent adds to a list for each opened entry. It includes the gap that the opened
/// entry leaves.
constexpr int kEntriesPerOpen = BallNode::kWidth + 1;
/// Smallest list that cannot overflow when entries are opened one at a time.
constexpr int kLeastListEntries = 2 * kMaxTreeDepth * kEntriesPerOpen + BallNode::kWidth;
/// Number of pairs of nodes that are opened before their children are opened.
constexpr int kOpenBatch = 32;
constexpr int kLeafBatch = 64;
constexpr int kLeafEntries = kLeafBatch + kOpenBatch * BallNode::kWidth + kListSlack;
constexpr int kBallEntries = kLeafBatch * kBlockWidth + kListSlack;
constexpr int kPairBatch = 1024;

/// Pairs of subtrees. `a`, `b`: node or block (without its leaf bit) of A and of B. `x`, `y`, `z`, `r`: bounding ball, in A's tree
/// frame, of the one of the two that is not opened next; in pairs of blocks it is that of B's block.
struct SubtreeList
{
	uint32_t *a, *b;
	float *x, *y, *z, *r;
	int size;
};

struct DescentFrame
{
	bool openA;
	int begin, end;
};

struct SearchCounts
{
	int64_t nodeVisits = 0, blockPairs = 0, ballTests = 0;
};

/// One search for pairs of balls that may intersect. On entry openA or openB has one entry. The search finds every pair that
/// intersects, and a few pairs that almost do.
struct PairSearch
{
	const BallNode *nodesA, *nodesB;
	const Sphere *ballsA, *ballsB;
	const StoredEllipsoid* ellipsoidsB;  ///< needed when movedB is not null
	double R[9], t[3];                   ///< transform from B's tree frame to A's
	float stretch;                       ///< largest factor by which R may lengthen a vector
	float slack;                         ///< bound on the rounding of float positions [m]
	SubtreeList openA, openB, leaves;
	int openBatch;
	uint32_t *ballOf, *blockOf;              ///< kBallEntries: balls of A against blocks of B
	BlockColumns* columnsA;                  ///< one for each block of A
	uint32_t* epochsA;                       ///< epoch in which each of these columns was last written
	BlockColumns* moved;                     ///< one for each block of B, in A's tree frame
	BlockMark* marks;                        ///< marks of these blocks
	MovedCenter* centersB;                   ///< centres of the balls of moved blocks, for the evaluation of pairs
	MomentEllipsoid* movedB;                 ///< these balls in A's tree frame; null: not needed
	uint32_t epoch;                          ///< number of this search; blocks with another number must still be written or moved
	uint32_t *pairA, *pairB;                 ///< found pairs as indices of balls, with room for kPairBatch + kListSlack
	void (*sink)(void* context, int count);  ///< receives the first `count` pairs
	void* context;
	bool stop;  ///< set by the sink when enough pairs are found
	SearchCounts counts;
};

/// The bodies of a list of pairs.
struct PairBodies
{
	const Sphere *ballsA, *ballsB;  ///< centres and radii; kLineTerms read nothing else
	const StoredEllipsoid *ellipsoidsA, *ellipsoidsB;
	const NormalGradient *gradientsA, *gradientsB;  ///< gradients in each body's own tree frame; null: none
	/// Centres of the balls of B in the pairs that the search found; null: each pair transforms its own ball.
	const MovedCenter* centersB;
	const MomentEllipsoid* movedB;  ///< B's balls in A's tree frame, in floats; valid if centersB is not null
	double R[9], t[3];
	bool keepMeeting;        ///< for `refine`: also keeps pairs that meet only with their bounding balls
	float slack;             ///< bound on the rounding of float positions [m]
	float margin;            ///< for `cull`: keeps pairs that may meet after points of B have moved by at most this distance [m]
	float weightA, weightB;  ///< weights of the fields, for the damping; both zero: no damping
};

/// Sums over pairs, in the units and axes of OverlapIntegrals.
enum Sum
{
	kVolume,
	kFirst,
	kSecond = kFirst + 3,
	kNormalA = kSecond + 6,  ///< force, torque
	kNormalB = kNormalA + 6,
	kLine = kNormalB + 6,  ///< sum dd L n, and sum C x (dd L n)
	kArea = kLine + 6,
	kDepthA = kArea + 3,
	kDepthB,
	kPairs,
	kProduct,                  ///< 6x12: g_n by (g_wA, g_wB), row-major
	kDamping = kProduct + 72,  ///< 3x3 blocks of sum dd L G G^T, each row-major: linear, linear by angular, angular
	kSumCount = kDamping + 27
};

enum Terms
{
	kLineTerms,      ///< packed spheres: density 1, no normals, no depths
	kFieldTerms,     ///< no line terms
	kStiffnessTerms  ///< field terms and stiffness
};

/// Intersecting pairs, with one column for each quantity that the sums and the grouping need.
struct PairStream
{
	enum Column
	{
		Mass,                      ///< dd L
		Area,                      ///< dd times the area of the disc
		Centroid,                  ///< C
		Normal = Centroid + 3,     ///< n
		MeanNormalA = Normal + 3,  ///< mean normal of A's ball at C; columns from here to DepthB are not written for packed spheres
		MeanNormalB = MeanNormalA + 3,
		DepthA = MeanNormalB + 3,  ///< depth in A at C
		DepthB,
		Force,             ///< dd L (m_j - m_i); the columns from here on are used for grouping only
		Size = Force + 3,  ///< |f|; 0 where the normals cancel to less than 0.1 dd L, so that f has no direction
		Rank,              ///< rank of the pair: |f|, or 0.001 dd L where that is more
		ColumnCount
	};
	uint32_t *a, *b;
	float* numbers;  ///< the columns, one after the other
	size_t stride;
};
/// First entry of a column. Internal linkage keeps the linker from merging it (see above).
static inline float* columnOf(const PairStream& stream, int column) { return stream.numbers + size_t(column) * stream.stride; }

/// Group of a pair. Patches are numbered from 0 up; a pair without a patch has the number of its component, from -1 down. It is a float
/// so that it fits the vectors of the other columns; it is exact up to 2^24.
using GroupNumber = float;

/// One pass over the pairs of a component that belong to no patch yet.
struct ConeSearch
{
	GroupNumber component, patch;
	float axis[3], cosine;             ///< pairs whose force is within the cone join the patch
	bool all;                          ///< all pairs of the component join, whatever their force
	double force[3], moment[3], rank;  ///< sums over the pairs that joined: f, C times the rank, and the rank
	double left;                       ///< sum of the rank over the pairs that did not join
	int strongest;                     ///< first pair of the largest size among those that did not join; negative: none has a direction
	float size;                        ///< size of the strongest pair
};

/// Patches with which a pair without a patch is compared.
struct PatchList
{
	const GroupNumber* component;  ///< component of each patch
	const float *center[3], *direction[3];
	int count;
	float perLength;  ///< weight of a distance, relative to the cosine of a direction [1/m]
};

struct QueryKernel
{
	void (*search)(PairSearch& search);
	/// Drops, in place, pairs whose ellipsoids are surely apart. Returns the new length. Reads up to kListSlack entries behind the end.
	int (*cull)(const PairBodies& bodies, uint32_t* a, uint32_t* b, int count);
	/// Adds the terms of the pairs that intersect to `sums`. Reads up to kListSlack entries behind the end.
	void (*evaluate)(const PairBodies& bodies, const uint32_t* a, const uint32_t* b, int count, Terms terms, double* sums);
	/// Appends the pairs that intersect to `stream` at `size`, which needs kListSlack entries beyond size + count. Returns the new
	/// size. Reads up to kListSlack entries behind the end.
	int (*refine)(
		const PairBodies& bodies, const uint32_t* a, const uint32_t* b, int count, Terms terms, const PairStream& stream, int size);
	/// Adds the terms of one group to `sums`, as `evaluate` does. It sums those of the first `count` pairs of `stream` whose group is
	/// `group`, or all of them if `groups` is null. Reads up to kListSlack entries behind the end; of `bodies` it reads only the
	/// weights.
	void (*sumGroup)(const PairBodies& bodies, const PairStream& stream, const GroupNumber* groups, GroupNumber group, int count,
		Terms terms, double* sums);
	/// Writes the patch's number to `groups` for the pairs that join it. Reads up to kListSlack entries behind the end.
	void (*joinCone)(const PairStream& stream, GroupNumber* groups, int count, ConeSearch& search);
	/// Each pair without a patch joins the best patch of its component, or the best of all patches if its component has none. Reads up
	/// to kListSlack entries behind the end and writes back what it read there.
	void (*joinNearest)(const PairStream& stream, GroupNumber* groups, int count, const PatchList& list);
	/// Finds the elements of a surface inside a body (ContactFaces.cpp).
	void (*findFaces)(FaceSearch& search);
	/// Depths at points (DepthIntegral.cpp).
	void (*sampleDepths)(const FieldTables& field, const DepthPoints& points);
};

extern const QueryKernel kPortableKernel;
#if defined(__x86_64__)
extern const QueryKernel kBaselineKernel, kV3Kernel, kV4Kernel;
#elif defined(__aarch64__)
extern const QueryKernel kNeonKernel;
#endif
}  // namespace ist::kernels
