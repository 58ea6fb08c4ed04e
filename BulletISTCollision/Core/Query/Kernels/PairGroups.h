// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/Kernels/PairIntegrals.h"

// Included by QueryKernel.cpp only. The passes over all pairs with which PatchGrouper groups them.
namespace
{
IST_INLINE F3 load3(const PairStream& stream, int column, int at)
{
	return {F::load(columnOf(stream, column) + at), F::load(columnOf(stream, column + 1) + at), F::load(columnOf(stream, column + 2) + at)};
}

/// Largest size so far in each lane, and its position.
struct StrongestLanes
{
	F size = F::all(0), place = F::all(0);
	IST_INLINE void take(uint32_t lanes, const F& s, int at)
	{
		const uint32_t larger = lanes & F::less(size, s);
		size = F::select(larger, s, size);
		place = F::select(larger, F::all(float(at)), place);
	}
	void finish(ConeSearch& search) const
	{
		float sizes[kLanes], places[kLanes];
		size.store(sizes);
		place.store(places);
		search.strongest = -1;
		search.size = 0;
		for (int k = 0; k < kLanes; ++k)
		{
			const int at = int(places[k]) + k;
			if (!(sizes[k] > search.size || (sizes[k] > 0 && sizes[k] == search.size && at < search.strongest))) continue;
			search.strongest = at;
			search.size = sizes[k];
		}
	}
};

/// Sums over the pairs that join a patch, one for each lane.
struct Joined
{
	F sums[7];
	IST_INLINE void clear()
	{
		for (F& s : sums) s = F::all(0);
	}
	IST_INLINE void take(uint32_t lanes, const F3& f, const F3& C, const F& rank)
	{
		const F zero = F::all(0), w = F::select(lanes, rank, zero);
		const F values[7] = {
			F::select(lanes, f.x, zero), F::select(lanes, f.y, zero), F::select(lanes, f.z, zero), C.x * w, C.y * w, C.z * w, w};
		for (int i = 0; i < 7; ++i) sums[i] += values[i];
	}
	void addTo(ConeSearch& search) const
	{
		for (int i = 0; i < 3; ++i)
		{
			search.force[i] += sums[i].sum();
			search.moment[i] += sums[3 + i].sum();
		}
		search.rank += sums[6].sum();
	}
};

void joinCone(const PairStream& stream, GroupNumber* groups, int count, ConeSearch& search)
{
	const F own = F::all(search.component), joining = F::all(search.patch), zero = F::all(0), cosine = F::all(search.cosine);
	const F3 axis{F::all(search.axis[0]), F::all(search.axis[1]), F::all(search.axis[2])};
	const uint32_t all = search.all ? ~0u : 0u;
	StrongestLanes strongest;
	for (int i = 0; i < 3; ++i) search.force[i] = search.moment[i] = 0;
	search.rank = search.left = 0;
	for (int first = 0; first < count; first += kStage)
	{
		const int end = count - first < kStage ? count : first + kStage;
		uint32_t any = 0;
		F left = zero;
		Joined joined;
		joined.clear();
		for (int k = first; k < end; k += kLanes)
		{
			const F group = F::load(groups + k);
			const uint32_t open = firstLanes(end - k) & F::equal(group, own);
			if (!open) continue;
			const F3 f = load3(stream, PairStream::Force, k);
			const F size = F::load(columnOf(stream, PairStream::Size) + k);
			const uint32_t join = open & (all | (F::less(zero, size) & ~F::less(dot(f, axis), cosine * size)));
			const F rank = F::load(columnOf(stream, PairStream::Rank) + k);
			left += F::select(open & ~join, rank, zero);
			strongest.take(open & ~join, size, k);
			if (!join) continue;
			any |= join;
			F::select(join, joining, group).store(groups + k);
			joined.take(join, f, load3(stream, PairStream::Centroid, k), rank);
		}
		search.left += left.sum();
		if (any) joined.addTo(search);
	}
	strongest.finish(search);
}

/// Patch with the highest score so far, in each lane. The score rates distance and direction.
struct BestPatch
{
	F score = F::all(-3e38f), patch = F::all(0);
	IST_INLINE void take(uint32_t lanes, const F& s, int p)
	{
		const uint32_t better = lanes & F::less(score, s);
		score = F::select(better, s, score);
		patch = F::select(better, F::all(float(p)), patch);
	}
};

void joinNearest(const PairStream& stream, GroupNumber* groups, int count, const PatchList& list)
{
	const F zero = F::all(0), perLength = F::all(list.perLength);
	for (int k = 0; k < count; k += kLanes)
	{
		const F group = F::load(groups + k);
		const uint32_t open = firstLanes(count - k) & F::less(group, zero);
		if (!open) continue;
		const F3 f = load3(stream, PairStream::Force, k), C = load3(stream, PairStream::Centroid, k);
		const F size = F::load(columnOf(stream, PairStream::Size) + k);
		const F perSize = F::select(F::less(zero, size), F::all(1) / size, zero);
		BestPatch ofOwn, ofAll;
		uint32_t hasOwn = 0;
		for (int p = 0; p < list.count; ++p)
		{
			const F3 d{C.x - F::all(list.center[0][p]), C.y - F::all(list.center[1][p]), C.z - F::all(list.center[2][p])};
			const F along = f.x * F::all(list.direction[0][p]) + f.y * F::all(list.direction[1][p]) + f.z * F::all(list.direction[2][p]);
			const F score = along * perSize - F::squareRoot(dot(d, d)) * perLength;
			const uint32_t own = F::equal(group, F::all(list.component[p]));
			hasOwn |= own;
			ofOwn.take(own, score, p);
			ofAll.take(~own, score, p);
		}
		const F best = F::select(hasOwn, ofOwn.patch, ofAll.patch);
		F::select(open, best, group).store(groups + k);
	}
}
}  // namespace
