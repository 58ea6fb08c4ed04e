// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/BallTree.h"
#include "BulletISTCollision/Core/Tree/TreeLimits.h"

#include <cstddef>
#include <cstdint>

// What the query's driver and its kernels share. Plain structs and raw pointers only: this header is compiled for several
// instruction sets, and a function that two of them define would be merged into one by the linker.
namespace ist::kernels
{
/// The balls of a block by columns, for the tests. `reach`: radius, of B's also the slack.
struct alignas(64) BlockColumns
{
	float x[kBlockWidth], y[kBlockWidth], z[kBlockWidth], reach[kBlockWidth];
};

/// When a block of B was moved last, and how many balls it has without padding.
struct BlockMark
{
	uint32_t epoch, count;
};

/// Of a ball of B: its centre in A's tree frame, unrounded, and its radius.
struct alignas(32) MovedCenter
{
	double x, y, z, R;
};

/// Room that a list of vectors needs behind its end: stores are always whole vectors.
constexpr int kListSlack = 16;
/// Entries that one level of the descent can add to a list for each entry that it opens, the hole it leaves included.
constexpr int kEntriesPerOpen = BallNode::kWidth + 1;
/// Smallest list that cannot overflow when entries are opened one at a time.
constexpr int kLeastListEntries = 2 * kMaxTreeDepth * kEntriesPerOpen + BallNode::kWidth;
/// Pairs of nodes that are opened before their children are.
constexpr int kOpenBatch = 32;
constexpr int kLeafBatch = 64;
constexpr int kLeafEntries = kLeafBatch + kOpenBatch * BallNode::kWidth + kListSlack;
constexpr int kBallEntries = kLeafBatch * kBlockWidth + kListSlack;
constexpr int kPairBatch = 1024;

/// Pairs of subtrees: node or block (without its leaf bit) of A and of B, and the bound of that one of the two which is not opened
/// next, in A's tree frame. Blocks: the bound of B's.
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

/// One search for pairs of balls that may intersect. It begins with the one entry of openA or openB. No pair that does intersect is missed;
/// a few that only almost do are found.
struct PairSearch
{
	const BallNode *nodesA, *nodesB;
	const Sphere *ballsA, *ballsB;
	const StoredEllipsoid* ellipsoidsB;  ///< where movedB is wanted
	double R[9], t[3];                   ///< B's tree frame to A's
	float stretch;                       ///< by how much R may lengthen
	float slack;                         ///< covers the rounding of float positions [m]
	SubtreeList openA, openB, leaves;
	int openBatch;
	uint32_t *ballOf, *blockOf;              ///< kBallEntries: balls of A against blocks of B
	BlockColumns* columnsA;                  ///< one for each block of A
	uint32_t* epochsA;                       ///< when these were written last
	BlockColumns* moved;                     ///< one for each block of B, in A's tree frame
	BlockMark* marks;                        ///< of these
	MovedCenter* centersB;                   ///< of the balls of moved blocks, for the pairs' evaluation
	MomentEllipsoid* movedB;                 ///< these balls; null: not wanted
	uint32_t epoch;                          ///< of this search: blocks with another one are still to be written, or moved
	uint32_t *pairA, *pairB;                 ///< kPairBatch + kListSlack: indices of balls
	void (*sink)(void* context, int count);  ///< takes the first `count` pairs
	void* context;
	bool stop;  ///< set by the sink: enough is found
	SearchCounts counts;
};

/// The bodies of a list of pairs.
struct PairBodies
{
	const Sphere *ballsA, *ballsB;  ///< all that kLineTerms read
	const StoredEllipsoid *ellipsoidsA, *ellipsoidsB;
	const NormalGradient *gradientsA, *gradientsB;  ///< in each body's own tree frame; null: none
	const MovedCenter* centersB;    ///< of those balls that the search found in pairs; null: each pair moves and turns its own
	const MomentEllipsoid* movedB;  ///< with centersB: B's balls in A's tree frame, in floats
	double R[9], t[3];
	bool keepMeeting;        ///< of `refine`: pairs whose bounding balls meet, whether or not they share volume
	float slack;             ///< covers the rounding of float positions [m]
	float margin;            ///< of `cull`: keeps pairs that meet when no point of B has moved further [m]
	float weightA, weightB;  ///< of the fields, for the damping; both zero: none
};

/// Sums over pairs, in the units and axes of OverlapIntegrals.
enum Sum
{
	kVolume,
	kFirst,
	kSecond = kFirst + 3,
	kNormalA = kSecond + 6,  ///< force, torque
	kNormalB = kNormalA + 6,
	kLine = kNormalB + 6,  ///< sum dd L n, and C x that
	kArea = kLine + 6,
	kDepthA = kArea + 3,
	kDepthB,
	kPairs,
	kProduct,                  ///< 6x12: g_n by (g_wA, g_wB), row major
	kDamping = kProduct + 72,  ///< 3x3 blocks of sum dd L G G^T, row major: linear, linear by angular, angular
	kSumCount = kDamping + 27
};

enum Terms
{
	kLineTerms,      ///< packed spheres: density 1, no normals, no depths
	kFieldTerms,     ///< no line terms
	kStiffnessTerms  ///< field terms and stiffness
};

/// Intersecting pairs, one column for each thing that sums and grouping need of them.
struct PairStream
{
	enum Column
	{
		Mass,                      ///< dd L
		Area,                      ///< dd times the disc's area
		Centroid,                  ///< C
		Normal = Centroid + 3,     ///< n
		MeanNormalA = Normal + 3,  ///< of A's leaf; all from here on: none of packed spheres
		MeanNormalB = MeanNormalA + 3,
		DepthA = MeanNormalB + 3,  ///< at C
		DepthB,
		Force,             ///< dd L (m_j - m_i); sums need none from here on
		Size = Force + 3,  ///< |f|; 0 where the normals cancel to less than a tenth of dd L, so that f has no direction
		Rank,              ///< of the pair: |f|, or a small share of dd L where that is more
		ColumnCount
	};
	uint32_t *a, *b;
	float* numbers;  ///< the columns, one after the other
	size_t stride;
};
/// Without linkage, see above.
static inline float* columnOf(const PairStream& stream, int column) { return stream.numbers + size_t(column) * stream.stride; }

/// What a pair belongs to: a patch, from 0 on, or as yet to a component alone, from -1 down. A float, to be looked at side by side with the
/// rest; exact up to 2^24.
using GroupNumber = float;

/// A look at those pairs of a component that belong to no patch yet.
struct ConeSearch
{
	GroupNumber component, patch;
	float axis[3], cosine;             ///< pairs whose force is within the cone join the patch
	bool all;                          ///< all of the component join it, whatever their force
	double force[3], moment[3], rank;  ///< of those that joined: sums of f, of C times the rank, of the rank
	double left;                       ///< sum of the rank of those that did not
	int strongest;                     ///< of those that did not, the first with the largest size; negative: none has a direction
	float size;                        ///< of that one
};

/// What a pair without a patch is compared with.
struct PatchList
{
	const GroupNumber* component;  ///< of each patch
	const float *center[3], *direction[3];
	int count;
	float perLength;  ///< what a distance counts beside the cosine of a direction [1/m]
};

struct QueryKernel
{
	void (*search)(PairSearch& search);
	/// Drops pairs whose ellipsoids are surely apart from a list in place; returns the new length. Reads up to kListSlack entries behind
	/// the end.
	int (*cull)(const PairBodies& bodies, uint32_t* a, uint32_t* b, int count);
	/// Adds the terms of those pairs that do intersect to `sums`. Reads up to kListSlack entries behind the end.
	void (*evaluate)(const PairBodies& bodies, const uint32_t* a, const uint32_t* b, int count, Terms terms, double* sums);
	/// Appends those pairs that do intersect to `stream` at `size` (needs kListSlack beyond size + count); returns the new size. Reads
	/// as far behind the end.
	int (*refine)(
		const PairBodies& bodies, const uint32_t* a, const uint32_t* b, int count, Terms terms, const PairStream& stream, int size);
	/// As `evaluate`, of those of the first `count` pairs of `stream` that are in a group; null: of all. Reads up to kListSlack behind the
	/// end; of the bodies the weights alone.
	void (*sumGroup)(const PairBodies& bodies, const PairStream& stream, const GroupNumber* groups, GroupNumber group, int count,
		Terms terms, double* sums);
	/// Writes the patch's number to `groups` for the pairs that join it. Reads as far behind the end.
	void (*joinCone)(const PairStream& stream, GroupNumber* groups, int count, ConeSearch& search);
	/// Pairs without a patch join the best in their component, or of all where it has none. Reads as far behind the end, and writes what it
	/// read there.
	void (*joinNearest)(const PairStream& stream, GroupNumber* groups, int count, const PatchList& list);
};

extern const QueryKernel kPortableKernel;
#if defined(__x86_64__)
extern const QueryKernel kBaselineKernel, kV3Kernel, kV4Kernel;
#endif
}  // namespace ist::kernels
