// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/Kernels/BallLanes.h"
#include "BulletISTCollision/Core/Query/Kernels/EllipsoidLanes.h"
#include "BulletISTCollision/Core/Query/Kernels/LaneCompressor.h"

// Included by QueryKernel.cpp only. The search works in stages without recursion and without unpredictable branches. Each step tests a
// vector and appends the survivors to a list without branching on hits; the next step works through that list.
namespace
{
using namespace ist;
using namespace ist::kernels;

static_assert(BallNode::kWidth == 8 && kBlockWidth == 16);

/// Appends first + lane to `lanes` for each lane that is set, and `same` to `beside`. `lanes` has `size` entries. Returns the new size.
/// `areFew`: whether more than half of the lanes are rarely set.
template <bool areFew>
IST_INLINE size_t appendLanes(const LaneMask<16>& set, uint32_t first, uint32_t same, uint32_t* lanes, uint32_t* beside, size_t size)
{
#if defined(IST_SSE) && defined(__AVX512VL__)
	const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
	const __m512i all = _mm512_add_epi32(_mm512_set1_epi32(int(first)), lane);
	const uint32_t bits = set.bits();
	const __m512i chosen = _mm512_maskz_compress_epi32(__mmask16(bits), all), other = _mm512_set1_epi32(int(same));
	const unsigned count = unsigned(__builtin_popcount(bits));
	// A store of a whole cache line mostly touches two lines, but an unpredictable branch costs more.
	if constexpr (!areFew)
	{
		_mm512_storeu_si512(lanes + size, chosen);
		_mm512_storeu_si512(beside + size, other);
		return size + count;
	}
	_mm256_storeu_si256(reinterpret_cast<__m256i*>(lanes + size), _mm512_castsi512_si256(chosen));
	_mm256_storeu_si256(reinterpret_cast<__m256i*>(beside + size), _mm512_castsi512_si256(other));
	if (__builtin_expect(count > 8, 0))
	{
		_mm256_storeu_si256(reinterpret_cast<__m256i*>(lanes + size + 8), _mm512_extracti64x4_epi64(chosen, 1));
		_mm256_storeu_si256(reinterpret_cast<__m256i*>(beside + size + 8), _mm512_castsi512_si256(other));
	}
	return size + count;
#elif defined(IST_SSE) && defined(__AVX2__)
	const uint32_t low = signBits(set.part[0]), high = signBits(set.part[1]);
	const size_t middle = size + unsigned(__builtin_popcount(low));
	const auto chosen = [](uint32_t b, __m256i base) {
		return _mm256_add_epi32(_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(kLaneTable.lane[b]))), base);
	};
	const __m256i base = _mm256_set1_epi32(int(first)), other = _mm256_set1_epi32(int(same));
	_mm256_storeu_si256(reinterpret_cast<__m256i*>(lanes + size), chosen(low, base));
	_mm256_storeu_si256(reinterpret_cast<__m256i*>(beside + size), other);
	_mm256_storeu_si256(reinterpret_cast<__m256i*>(lanes + middle), chosen(high, _mm256_add_epi32(base, _mm256_set1_epi32(8))));
	_mm256_storeu_si256(reinterpret_cast<__m256i*>(beside + middle), other);
	return middle + unsigned(__builtin_popcount(high));
#elif defined(IST_SSE) || defined(IST_NEON)
	using Words = LaneMask<16>::Part;
	uint32_t bytes[2];
	set.writeBytes(bytes);
	const Words base = Words{} + int32_t(first), other = Words{} + int32_t(same);
	const auto putSame = [&](size_t at) __attribute__((always_inline))
	{
		std::memcpy(beside + at, &other, sizeof other);
		std::memcpy(beside + at + 4, &other, sizeof other);
	};
	const auto put = [&](int half, size_t at) __attribute__((always_inline))
	{
		Words chosen[2];
		std::memcpy(chosen, kWideLaneTable.lane[half][bytes[half]], sizeof chosen);
		IST_UNROLL
		for (int i = 0; i < 2; ++i)
		{
			const Words to = base + chosen[i];
			std::memcpy(lanes + at + 4 * i, &to, sizeof to);
		}
		return at + kCountTable.count[bytes[half]];
	};
	const size_t end = put(1, put(0, size));
	putSame(size);
	putSame(size + 8);
	return end;
#else
	for (uint32_t bits = set.bits(); bits; bits &= bits - 1)
	{
		lanes[size] = first + uint32_t(__builtin_ctz(bits));
		beside[size++] = same;
	}
	return size;
#endif
}

IST_INLINE void fill8(uint32_t* to, uint32_t value)
{
#if defined(IST_SSE) && defined(__AVX2__)
	_mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_set1_epi32(int(value)));
#else
	for (int k = 0; k < 8; ++k) to[k] = value;
#endif
}

/// Children of a node. Those that pass the test are paired with one partner.
struct Children
{
	const uint32_t* id;
	Vector8 x, y, z, r;
};
struct Partner
{
	uint32_t id;
	float x, y, z, r;

	IST_INLINE BallLanes<8> grown(float slack) const
	{
		return {Vector8::all(x), Vector8::all(y), Vector8::all(z), Vector8::all(r + slack)};
	}
};

/// Appends pairs (child, partner); `child` and `partner` are the list's columns. The stored bound is that of the child.
IST_INLINE void appendChildBounds(SubtreeList& list, uint32_t* child, uint32_t* partner, uint32_t bits, const Children& c, const Partner& p)
{
	if constexpr (!kCompresses)
	{
		if (!bits) return;
		float x[8], y[8], z[8], r[8];
		c.x.store(x);
		c.y.store(y);
		c.z.store(z);
		c.r.store(r);
		size_t n = size_t(list.size);
		for (; bits; bits &= bits - 1, ++n)
		{
			const int k = __builtin_ctz(bits);
			child[n] = c.id[k];
			partner[n] = p.id;
			list.x[n] = x[k];
			list.y[n] = y[k];
			list.z[n] = z[k];
			list.r[n] = r[k];
		}
		list.size = int(n);
		return;
	}
	const Compressor compressor(bits);
	const int n = list.size;
	compressor.move(c.id, child + n);
	compressor.move(c.x, list.x + n);
	compressor.move(c.y, list.y + n);
	compressor.move(c.z, list.z + n);
	compressor.move(c.r, list.r + n);
	fill8(partner + n, p.id);
	list.size = n + compressor.count();
}

/// Appends pairs (child, partner) as above; the stored bound is that of the partner.
IST_INLINE void appendPartnerBounds(
	SubtreeList& list, uint32_t* child, uint32_t* partner, uint32_t bits, const Children& c, const Partner& p)
{
	if constexpr (!kCompresses)
	{
		size_t n = size_t(list.size);
		for (; bits; bits &= bits - 1, ++n)
		{
			child[n] = c.id[__builtin_ctz(bits)];
			partner[n] = p.id;
			list.x[n] = p.x;
			list.y[n] = p.y;
			list.z[n] = p.z;
			list.r[n] = p.r;
		}
		list.size = int(n);
		return;
	}
	const Compressor compressor(bits);
	const int n = list.size;
	compressor.move(c.id, child + n);
	fill8(partner + n, p.id);
	Vector8::all(p.x).store(list.x + n);
	Vector8::all(p.y).store(list.y + n);
	Vector8::all(p.z).store(list.z + n);
	Vector8::all(p.r).store(list.r + n);
	list.size = n + compressor.count();
}

struct LaneBits
{
	uint32_t present, leaf;
};

IST_INLINE LaneBits childBits(const uint32_t* child)
{
#if defined(IST_SSE) && defined(__AVX2__)
	const __m256i id = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(child));
	const __m256i none = _mm256_cmpeq_epi32(id, _mm256_set1_epi32(-1));
	return {uint32_t(_mm256_movemask_ps(_mm256_castsi256_ps(none))) ^ 0xff, uint32_t(_mm256_movemask_ps(_mm256_castsi256_ps(id)))};
#else
	LaneMask<8> none, leaf;
	IST_UNROLL
	for (int i = 0; i < LaneMask<8>::kParts; ++i)
	{
		LaneMask<8>::Part id;
		std::memcpy(&id, child + 4 * i, sizeof id);
		none.part[i] = id == int32_t(BallNode::kNoChild);
		leaf.part[i] = id < 0;
	}
	return {none.bits() ^ 0xff, leaf.bits()};
#endif
}

/// Destinations of the children of an opened node. `same`: the opened side is opened again next; `other`: the partner is opened next;
/// `leaf`: both are blocks.
struct Routes
{
	uint32_t same, other, leaf;
};

/// Decides which node of each pair is opened next: the larger one. A block is never opened.
IST_INLINE Routes route(uint32_t hits, LaneBits bits, uint32_t notSmaller, bool partnerIsLeaf)
{
	const uint32_t partnerLeaf = 0u - uint32_t(partnerIsLeaf);
	hits &= bits.present;
	const uint32_t leaf = hits & bits.leaf & partnerLeaf, same = hits & ~bits.leaf & (notSmaller | partnerLeaf);
	return {same, hits & ~(leaf | same), leaf};
}

/// Copy of the members of PairSearch that the descent reads. The compiler knows that vector stores cannot alias it.
struct Descent
{
	const BallNode *nodesA, *nodesB;
	Vector8 R[9], t[3], stretch;
	float slack;
};

/// Opens entry `index` of openA: the children of A's node against the bound of B's.
IST_INLINE void openNodeA(const Descent& s, int index, SubtreeList& sameList, SubtreeList& otherList, SubtreeList& leaves)
{
	const BallNode& node = s.nodesA[sameList.a[index]];
	const Partner b{sameList.b[index], sameList.x[index], sameList.y[index], sameList.z[index], sameList.r[index]};
	const Children c{node.child, Vector8::load(node.x), Vector8::load(node.y), Vector8::load(node.z), Vector8::load(node.r)};
	const uint32_t hits = touching(c.x, c.y, c.z, c.r, b.grown(s.slack)).bits();
	const uint32_t notSmaller = ~Vector8::less(c.r, Vector8::all(b.r));
	const Routes to = route(hits, childBits(node.child), notSmaller, (b.id & BallNode::kLeafBit) != 0);
	appendPartnerBounds(sameList, sameList.a, sameList.b, to.same, c, b);
	if (b.id & BallNode::kLeafBit) appendPartnerBounds(leaves, leaves.a, leaves.b, to.leaf, c, b);
	else appendChildBounds(otherList, otherList.a, otherList.b, to.other, c, b);
}

/// Opens entry `index` of openB: the children of B's node, transformed to A's frame, against the bound of A's.
IST_INLINE void openNodeB(const Descent& s, int index, SubtreeList& sameList, SubtreeList& otherList, SubtreeList& leaves)
{
	const BallNode& node = s.nodesB[sameList.b[index]];
	const Partner a{sameList.a[index], sameList.x[index], sameList.y[index], sameList.z[index], sameList.r[index]};
	const Vector8 x = Vector8::load(node.x), y = Vector8::load(node.y), z = Vector8::load(node.z);
	const auto row = [&](int i) { return s.R[3 * i] * x + s.R[3 * i + 1] * y + s.R[3 * i + 2] * z + s.t[i]; };
	const Children c{node.child, row(0), row(1), row(2), Vector8::load(node.r) * s.stretch};
	const uint32_t hits = touching(c.x, c.y, c.z, c.r, a.grown(s.slack)).bits();
	// If two nodes are equally large, the node of A is opened.
	const uint32_t notSmaller = Vector8::less(Vector8::all(a.r), c.r);
	const Routes to = route(hits, childBits(node.child), notSmaller, (a.id & BallNode::kLeafBit) != 0);
	appendPartnerBounds(sameList, sameList.b, sameList.a, to.same, c, a);
	// This has no branch, because it is unpredictable which partner is a leaf.
	SubtreeList& list = *(a.id & BallNode::kLeafBit ? &leaves : &otherList);
	appendChildBounds(list, list.b, list.a, to.leaf | to.other, c, a);
}

/// Transforms the ellipsoids of a block to A's frame; `centers` are already in it.
void moveEllipsoids(const PairSearch& s, const BlockColumns& centers, size_t first)
{
	MomentEllipsoid* const to = s.movedB + first;
	uint32_t index[kLanes];
	for (int k = 0; k < kLanes; ++k) index[k] = uint32_t(k);
	for (int lane = 0; lane < kBlockWidth; lane += kLanes)
	{
		const Balls b = fetch(s.ballsB + first + lane, s.ellipsoidsB + first + lane, index);
		const F3 normal = turned(s.R, b.normal);
		const F6 shape = turned(s.R, b.shape);
		storeRow(to + lane, 0, F::load(centers.x + lane), F::load(centers.y + lane), F::load(centers.z + lane), b.R);
		storeRow(to + lane, 4, b.density, normal.x, normal.y, normal.z);
		storeRow(to + lane, 8, b.depth, F::all(0), shape.xx, shape.yy);
		storeRow(to + lane, 12, shape.zz, shape.xy, shape.xz, shape.yz);
	}
}

void moveBlock(const PairSearch& s, uint32_t index)
{
	using V = FloatVector<kBlockWidth>;
	BlockColumns& moved = s.moved[index];
	const size_t first = size_t(index) * kBlockWidth;
	const Block block = fetchBlock(s.ballsB + first);
	IST_UNROLL
	for (int part = 0; part < V::kParts; ++part)
	{
		const int lane = part * kLanes;
		const F R{block.r.part[part]};
		const D x = D::from(F{block.x.part[part]}), y = D::from(F{block.y.part[part]}), z = D::from(F{block.z.part[part]});
		const auto component = [&](int i) __attribute__((always_inline)) { return movedComponent(s.R, s.t, i, x, y, z); };
		const Centers c{component(0), component(1), component(2), D::from(R)};
		c.x.rounded().store(moved.x + lane);
		c.y.rounded().store(moved.y + lane);
		c.z.rounded().store(moved.z + lane);
		(R + F::all(s.slack)).store(moved.reach + lane);
		storeCenters(s.centersB + first + lane, c);
	}
	s.marks[index] = {s.epoch, uint32_t(countBits(V::less(V::all(0), block.r)))};
	if (s.movedB) moveEllipsoids(s, moved, first);
}

/// Writes a block of A as columns, once per search, because a block is tested against many others.
void writeColumns(const PairSearch& s, uint32_t index)
{
	const Block block = fetchBlock(s.ballsA + size_t(index) * kBlockWidth);
	BlockColumns& to = s.columnsA[index];
	block.x.store(to.x);
	block.y.store(to.y);
	block.z.store(to.z);
	block.r.store(to.reach);
	s.epochsA[index] = s.epoch;
}

/// Lists A's balls near the bound of B's block, for up to kLeafBatch pairs of blocks from `first` on. Returns their number.
int ballsNearBlocks(PairSearch& s, int first, int end)
{
	using V = FloatVector<kBlockWidth>;
	const BlockColumns* columnsA = s.columnsA;
	const uint32_t* epochsA = s.epochsA;
	const BlockMark* marks = s.marks;
	const SubtreeList leaves = s.leaves;
	uint32_t *ballOf = s.ballOf, *blockOf = s.blockOf;
	const float slack = s.slack;
	const uint32_t epoch = s.epoch;
	size_t n = 0, tests = 0;
	for (int i = first; i < end; ++i)
	{
		const uint32_t blockA = leaves.a[i] & ~BallNode::kLeafBit, blockB = leaves.b[i] & ~BallNode::kLeafBit;
		if (epochsA[blockA] != epoch) writeColumns(s, blockA);
		const BlockColumns& a = columnsA[blockA];
		// Padding finds no pairs: A's is far from all bounds of B that touch one of A's, and B's is far from all balls.
		const BallLanes<16> bound{V::all(leaves.x[i]), V::all(leaves.y[i]), V::all(leaves.z[i]), V::all(leaves.r[i] + slack)};
		const LaneMask<16> near = touching(V::loadAligned(a.x), V::loadAligned(a.y), V::loadAligned(a.z), V::loadAligned(a.reach), bound);
		const size_t size = appendLanes<false>(near, blockA * kBlockWidth, blockB, ballOf, blockOf, n), count = size - n;
		if ((count != 0) & (marks[blockB].epoch != epoch)) moveBlock(s, blockB);
		// If no ball of A is near a block of B, `count` is 0, so the block's number of balls has no effect.
		tests += count * marks[blockB].count;
		n = size;
	}
	s.counts.blockPairs += end - first;
	s.counts.ballTests += int64_t(tests);
	return int(n);
}

/// Tests balls of A against blocks of B. The sink receives the found pairs whenever the buffer is full. `pairs`: number of pairs
/// already in the buffer.
int pairsOfBalls(PairSearch& s, int count, int pairs)
{
	using V = FloatVector<kBlockWidth>;
	const uint32_t *ballOf = s.ballOf, *blockOf = s.blockOf;
	uint32_t *pairA = s.pairA, *pairB = s.pairB;
	const Sphere* ballsA = s.ballsA;
	const BlockColumns* moved = s.moved;
	for (int i = 0; i < count && !s.stop;)
	{
		const int safe = (kPairBatch - pairs) / kBlockWidth;
		if (safe == 0)
		{
			s.sink(s.context, pairs);
			pairs = 0;
			continue;
		}
		const int end = count - i < safe ? count : i + safe;
		size_t size = size_t(pairs);
		for (; i < end; ++i)
		{
			const uint32_t ball = ballOf[i], index = blockOf[i];
			const BallLanes<16> a = BallLanes<16>::of(&ballsA[ball].x);
			const BlockColumns& b = moved[index];
			const LaneMask<16> hits = nearlyTouching(
				V::loadAligned(b.x), V::loadAligned(b.y), V::loadAligned(b.z), V::loadAligned(b.reach), a);
			size = appendLanes<true>(hits, index * kBlockWidth, ball, pairB, pairA, size);
		}
		pairs = int(size);
	}
	return pairs;
}

/// Processes the list of pairs of blocks and empties it.
int drainLeaves(PairSearch& s, int pairs)
{
	for (int first = 0; first < s.leaves.size && !s.stop; first += kLeafBatch)
	{
		const int end = s.leaves.size - first < kLeafBatch ? s.leaves.size : first + kLeafBatch;
		const int near = ballsNearBlocks(s, first, end);
		pairs = pairsOfBalls(s, near, pairs);
	}
	s.leaves.size = 0;
	return pairs;
}

/// On entry openA or openB holds the pair of roots. Entries are opened in batches, the deepest first. So the lists stay short, and the
/// steps within a batch are independent. Each frame is a run of entries of one list. The children of a batch lie behind all entries
/// that are still open.
void search(PairSearch& s)
{
	DescentFrame frames[4 * kMaxTreeDepth + 4];
	frames[0] = {s.openA.size > 0, 0, 1};
	int depth = 1, pairs = 0;
	Descent d{s.nodesA, s.nodesB, {}, {}, Vector8::all(s.stretch), s.slack};
	for (int i = 0; i < 9; ++i) d.R[i] = Vector8::all(float(s.R[i]));
	for (int i = 0; i < 3; ++i) d.t[i] = Vector8::all(float(s.t[i]));
	while (depth > 0 && !s.stop)
	{
		DescentFrame& frame = frames[depth - 1];
		SubtreeList& own = frame.openA ? s.openA : s.openB;
		if (frame.begin == frame.end)
		{
			own.size = frame.begin;
			--depth;
			continue;
		}
		const int end = frame.end, batch = end - frame.begin < s.openBatch ? end - frame.begin : s.openBatch;
		own.size = end;
		frame.end = end - batch;
		SubtreeList A = s.openA, B = s.openB, leaves = s.leaves;
		if (frame.openA)
			for (int i = end - batch; i < end; ++i) openNodeA(d, i, A, B, leaves);
		else
			for (int i = end - batch; i < end; ++i) openNodeB(d, i, B, A, leaves);
		s.counts.nodeVisits += batch;
		const int beginA = s.openA.size, beginB = s.openB.size;
		s.openA.size = A.size;
		s.openB.size = B.size;
		s.leaves.size = leaves.size;
		if (B.size > beginB) frames[depth++] = {false, beginB, B.size};
		if (A.size > beginA) frames[depth++] = {true, beginA, A.size};
		if (s.leaves.size >= kLeafBatch) pairs = drainLeaves(s, pairs);
	}
	pairs = drainLeaves(s, pairs);
	if (pairs > 0 && !s.stop) s.sink(s.context, pairs);
}
}  // namespace
