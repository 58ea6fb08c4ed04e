// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/Kernels/PairIntegrals.h"

// Included by QueryKernel.cpp only. Pairs that must be grouped are evaluated once and stored in columns. The columns are summed when the
// groups are known.
namespace
{
/// Calls `visit(column, lanes)` for each column of a list.
template <Terms terms, class Visit> IST_INLINE void forEachListed(const Lenses& l, const Visit& visit)
{
	constexpr float kWeakNormal = 0.1f, kLeastRank = 1e-3f;
	forEachColumn<terms>(l, visit);
	const F zero = F::all(0);
	const F3 f = terms == kLineTerms ? F3{zero, zero, zero}
									 : F3{l.mass * (l.mB.x - l.mA.x), l.mass * (l.mB.y - l.mA.y), l.mass * (l.mB.z - l.mA.z)};
	const F length = F::squareRoot(dot(f, f));
	visit(PairStream::Force, f.x);
	visit(PairStream::Force + 1, f.y);
	visit(PairStream::Force + 2, f.z);
	visit(PairStream::Size, F::select(F::isLess(length, F::all(kWeakNormal) * l.mass), zero, length));
	visit(PairStream::Rank, F::larger(length, F::all(kLeastRank) * l.mass));
}

template <Terms terms, bool isMoved, bool normalsChange>
int refinePairs(const PairBodies& bodies, const uint32_t* a, const uint32_t* b, int count, const PairStream& stream, int size)
{
	for (int k = 0; k < count; k += kLanes)
	{
		const Lenses l = lensesOf<terms, isMoved, normalsChange>(bodies, a + k, b + k);
		const LaneCompressor kept((bodies.keepMeeting ? l.meeting : l.hits).bits() & firstLanes(count - k));
		kept.move(a + k, stream.a + size);
		kept.move(b + k, stream.b + size);
		forEachListed<terms>(
			l, [&](int c, const F& v) __attribute__((always_inline)) { kept.move(v, columnOf(stream, c) + size); });
		size += kept.count();
	}
	return size;
}

template <Terms terms>
int refineAs(const PairBodies& bodies, const uint32_t* a, const uint32_t* b, int count, const PairStream& stream, int size)
{
	return specialized<terms>(bodies,
		[&](auto isMoved, auto normalsChange) { return refinePairs<terms, isMoved, normalsChange>(bodies, a, b, count, stream, size); });
}

int refine(const PairBodies& bodies, const uint32_t* a, const uint32_t* b, int count, Terms terms, const PairStream& stream, int size)
{
	return terms == kLineTerms ? refineAs<kLineTerms>(bodies, a, b, count, stream, size)
							   : refineAs<kFieldTerms>(bodies, a, b, count, stream, size);
}

/// Copies the lanes of the set bits to the stage. Writes whole vectors.
template <int Columns> IST_INLINE void stageLanes(const PairStream& from, int at, uint32_t bits, Stage& stage, int length)
{
	if (bits == kAllLanes)
	{
		IST_UNROLL
		for (int c = 0; c < Columns; ++c) F::load(columnOf(from, c) + at).store(stage.column[c] + length);
		return;
	}
	const LaneCompressor compressor(bits);
	for (int c = 0; c < Columns; ++c) compressor.move(F::load(columnOf(from, c) + at), stage.column[c] + length);
}

template <Terms terms>
void sumListed(const PairBodies& bodies, const PairStream& stream, const GroupNumber* groups, GroupNumber group, int count, double* sums)
{
	constexpr int kColumns = kSummedColumns<terms>;
	Stage stage;
	int length = 0;
	int64_t pairs = 0;
	for (int k = 0; k < count; k += kLanes)
	{
		uint32_t bits = firstLanes(count - k);
		if (groups) bits &= F::equal(F::load(groups + k), F::all(group));
		if (!bits) continue;
		stageLanes<kColumns>(stream, k, bits, stage, length);
		length += countLanes(bits);
		// The list may contain pairs that meet only with their bounding balls. They have no mass and are not counted.
		pairs += countLanes(bits & F::less(F::all(0), F::load(columnOf(stream, PairStream::Mass) + k)));
		if (length > kStage - kLanes) flushStage<terms>(bodies, stage, length, sums);
	}
	if (length > 0) flushStage<terms>(bodies, stage, length, sums);
	sums[kPairs] += double(pairs);
}

void sumGroup(
	const PairBodies& bodies, const PairStream& stream, const GroupNumber* groups, GroupNumber group, int count, Terms terms, double* sums)
{
	switch (terms)
	{
	case kLineTerms: return sumListed<kLineTerms>(bodies, stream, groups, group, count, sums);
	case kFieldTerms: return sumListed<kFieldTerms>(bodies, stream, groups, group, count, sums);
	case kStiffnessTerms: return sumListed<kStiffnessTerms>(bodies, stream, groups, group, count, sums);
	}
}
}  // namespace
