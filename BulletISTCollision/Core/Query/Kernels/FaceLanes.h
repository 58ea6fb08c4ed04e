// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/Kernels/DepthFit.h"
#include "BulletISTCollision/Core/Query/Kernels/LaneCompressor.h"

// Included by QueryKernel.cpp only. Finds the elements of a surface inside a body, and their integrals, several elements side by side.
// Batches have the same elements for every number of lanes, so every set finds the same faces in the same order.
namespace
{
/// A part of a ball can only lie inside a body if its center is less than this many radii outside; the depth outside is not exact.
constexpr float kOutsideSlack = 1.3f;
/// An element at the rim is quartered if its samples are farther than this share of its size from a quadratic function.
constexpr float kMostMisfit = 0.01f;
/// With more than this share, it is cut at the planes: a few samples say little about a body that is thinner than the element.
constexpr float kCreaseMisfit = 0.1f;
/// In cells without error, elements are cut at the planes if the depth at a corner is off by more than this share of the size.
constexpr float kExactMisfit = 1e-4f;
/// The zero level is taken as a parabola while the depth bends by less than this share of its largest value. With more, it may cross an
/// edge twice, and most of a shallow contact would be lost.
constexpr float kMostBend = 0.5f;
/// A smaller share of an element counts as nothing. The corner of another body that just touches a large face is a millionth of it; below
/// this, as wide as the rounding of coordinates, rounding would decide where its center is.
constexpr float kLeastShare = 1e-12f;

constexpr int kNodesPerVisit = 4, kNodeStack = 1024, kWaiting = 128;
static_assert(kNodesPerVisit * 4 == kFaceBatch);

/// A list of elements that wait until there are enough of them.
struct WaitingElements
{
	uint32_t index[kWaiting + kFaceBatch];
	int count = 0;
	bool isFull() const { return count > kWaiting - kFaceBatch; }
};

class FaceFinder
{
public:
	explicit FaceFinder(FaceSearch& search) : m_search(search) {}

	void run()
	{
		m_stack[m_top++] = 0;
		while (m_top > 0 && !m_search.stop)
		{
			const int count = m_top < kNodesPerVisit ? m_top : kNodesPerVisit;
			m_top -= count;
			uint32_t index[kNodesPerVisit];
			for (int k = 0; k < kNodesPerVisit; ++k) index[k] = m_stack[m_top + (k < count ? k : count - 1)];
			m_search.nodes += count;
			m_fits = m_top + kFaceBatch <= kNodeStack;
			for (int k = 0; k < count; k += kLanes / 4) visit(index + k, count - k);
			if (m_candidates.isFull()) sampleAll();
		}
		sampleAll();
	}

private:
	void visit(const uint32_t* nodes, int count);
	IST_INLINE F beyondDomain(const F3& x) const;

	void sampleAll();
	void sampleQuarters();
	template <bool isQuarter> void sample(const uint32_t* list, int count);
	template <bool isQuarter> void sampleLanes(const uint32_t* list, int first, uint32_t lanes);
	IST_INLINE F misfitOfCorners(const ElementLanes& e, const CornerDepths& corners) const;

	void clearBatch() { m_batch.faces = m_batch.cut = m_batch.planes = 0; }
	void sendBatch()
	{
		if (m_batch.faces | m_batch.cut | m_batch.planes) m_search.take(m_search.context, m_batch);
	}
	IST_INLINE void put(int column, int first, const F& f) { f.store(m_batch.column[column] + first); }
	IST_INLINE void put(int column, int first, const F3& f)
	{
		put(column, first, f.x);
		put(column + 1, first, f.y);
		put(column + 2, first, f.z);
	}
	/// Replaces the lanes of the set bits only.
	IST_INLINE void put(int column, int first, const F& f, uint32_t lanes)
	{
		put(column, first, lanes == kAllLanes ? f : F::select(lanes, f, F::load(m_batch.column[column] + first)));
	}
	IST_INLINE void put(int column, int first, const F3& f, uint32_t lanes)
	{
		put(column, first, f.x, lanes);
		put(column + 1, first, f.y, lanes);
		put(column + 2, first, f.z, lanes);
	}
	IST_INLINE void putFrame(int first, const ElementLanes& e, const DepthFit& fit, const F& flush);
	IST_INLINE void putFaces(
		int first, const ElementLanes& e, const RegionMoments& m, const DepthFit& fit, const F& top, const F& cut, uint32_t lanes);
	IST_INLINE void putFlush(int first, const ElementLanes& e, const F& depth, const F& flush, uint32_t lanes);

	FaceSearch& m_search;
	uint32_t m_stack[kNodeStack + kFaceBatch];
	int m_top = 0;
	bool m_fits = true;                        // whether the stack has room for all children of this visit
	WaitingElements m_candidates, m_quarters;  // quarters: 4 element + quarter
	FaceBatch m_batch;
};

/// How far points lie beyond the domain; negative inside [m].
IST_INLINE F FaceFinder::beyondDomain(const F3& x) const
{
	F beyond = all(-1e30f);
	const auto extend = [&](const F& v, int axis) __attribute__((always_inline))
	{
		beyond = F::larger(beyond, F::larger(all(m_search.domainLower[axis]) - v, v - all(m_search.domainUpper[axis])));
	};
	extend(x.x, 0);
	extend(x.y, 1);
	extend(x.z, 2);
	return beyond;
}

/// Children of nodes that may reach into the body go on: nodes to the stack, elements to a list.
__attribute__((noinline)) void FaceFinder::visit(const uint32_t* nodes, int count)
{
	static_assert(sizeof(SurfaceQuad) == 80);
	constexpr int offset[5] = {0, 16, 32, 48, 64};
	F::Part c[5];
	gather<1, 5>(0, placesOf(m_search.quads, nodes), offset, c);
	const F3 x = moved(m_search, {{c[0]}, {c[1]}, {c[2]}});
	const F radius{c[3]}, beyond = beyondDomain(x);
	const Int child = (Int)c[4];
	Int part[1];
	findParts<1>(m_search, {x}, part);
	const DepthLanes at = depthIn(fetchCells(m_search, part[0]), x);

	const uint32_t outside = F::less(all(0), beyond), lanes = 4 * count < kLanes ? (1u << (4 * count)) - 1 : kAllLanes;
	// Far from its samples a quadric falls too steeply: its value divided by its slope is then a better distance.
	const F depth = at.depth + all(3) * at.error, reach = all(kOutsideSlack) * radius;
	const F slope2 = dot(at.gradient, at.gradient);
	const uint32_t farOutside = F::less(depth + reach, all(0)) & F::less(reach * reach * slope2, depth * depth);
	const uint32_t away = (outside & F::less(radius, beyond + all(m_search.margin))) | (~outside & farOutside);
	const uint32_t go = ~F::less(radius, all(0)) & ~away & lanes, element = signBits(child);
	const uint32_t uncut = go & element & (F::less(all(0), beyond + radius) | F::less(all(m_search.largest), radius));

	const LaneCompressor inner(go & ~element), candidates(go & element & ~uncut);
	uint32_t index[kLanes];
	store(child & int32_t(~SurfaceNode::kElement), index);
	if (m_fits)
	{
		inner.move(index, m_stack + m_top);
		m_top += inner.count();
	}
	else m_search.dropped += inner.count();
	candidates.move(index, m_candidates.index + m_candidates.count);
	m_candidates.count += candidates.count();
	for (uint32_t b = uncut; b; b &= b - 1) m_search.takeUncut(m_search.context, index[__builtin_ctz(b)]);
}

void FaceFinder::sampleAll()
{
	for (int k = 0; k < m_candidates.count; k += kFaceBatch)
	{
		sample<false>(m_candidates.index + k, m_candidates.count - k);
		if (m_quarters.count > kWaiting - 4 * kFaceBatch) sampleQuarters();
	}
	m_candidates.count = 0;
	sampleQuarters();
}

void FaceFinder::sampleQuarters()
{
	for (int k = 0; k < m_quarters.count; k += kFaceBatch) sample<true>(m_quarters.index + k, m_quarters.count - k);
	m_quarters.count = 0;
}

template <bool isQuarter> void FaceFinder::sample(const uint32_t* list, int count)
{
	count = count < kFaceBatch ? count : kFaceBatch;
	(isQuarter ? m_search.quarters : m_search.sampled) += count;
	clearBatch();
	m_batch.isOfQuarters = isQuarter;
	uint32_t padded[kFaceBatch];
	for (int k = 0; k < kFaceBatch; ++k) padded[k] = list[k < count ? k : count - 1];
	for (int first = 0; first < count; first += kLanes)
		sampleLanes<isQuarter>(padded + first, first, count - first < kLanes ? (1u << (count - first)) - 1 : kAllLanes);
	sendBatch();
}

/// How far the fit is from the depth at the corners [m]. Outside, where the depth is not known, as far as it is positive.
IST_INLINE F FaceFinder::misfitOfCorners(const ElementLanes& e, const CornerDepths& corners) const
{
	F3 x[4];
	Int part[4];
	IST_UNROLL
	for (int i = 0; i < 4; ++i)
		x[i] = e.center + corners.s[i] * e.e1 + corners.t[i] * e.e2 -
			(e.k12 * corners.s[i] * corners.t[i] + all(1 / 3.0f) * (e.k11 + e.k22)) * e.unit;
	findParts(m_search, x, part);
	F misfit = all(0);
	_Pragma("GCC unroll 1") for (int i = 0; i < 4; ++i)
	{
		const DepthLanes at = depthAt(m_search, part[i], x[i]);
		const F off = absolute(at.depth - corners.depth[i]);
		misfit = F::larger(misfit, F::select(at.outside, F::larger(corners.depth[i], all(0)), off));
	}
	return misfit;
}

/// Samples the depth and fits a quadratic function of the coordinates. Whole elements become faces, and those that the zero level crosses
/// once; of the others, some are quartered and the rest is cut by the caller.
template <bool isQuarter> __attribute__((noinline)) void FaceFinder::sampleLanes(const uint32_t* list, int first, uint32_t lanes)
{
	alignas(64) uint32_t index[kLanes];
	uint32_t right = 0, upper = 0;
	for (int k = 0; k < kLanes; ++k)
	{
		index[k] = list[k] >> (isQuarter ? 2 : 0);
		right |= (list[k] & 1) << k;
		upper |= (list[k] >> 1 & 1) << k;
	}
	ElementLanes e = fetchElements(m_search, index);
	if constexpr (isQuarter) takeQuarters(e, right, upper);
	DepthSamples samples;
	sampleDepth(m_search, e, samples);
	const uint32_t near = lanes & ~samples.astray;
	const DepthFit fit = fitOf(e, samples);
	const CornerDepths corners = cornersOf(e, fit);

	const F size = F::squareRoot(dot(e.e1, e.e1) + dot(e.e2, e.e2)), bend = corners.middle - corners.mean;
	// Only surfaces that look the same way can lie in each other; those of bodies that touch look at each other.
	const F alike = F::smaller(F::larger(all(-2) * dot(samples.gradient, e.unit), all(0)), all(1));
	const F flush = all(kFlushErrors) * alike * (samples.error + e.error) + all(m_search.rounding);
	const F top = corners.largest + F::larger(all(0), bend);
	F misfit = misfitOf(e, samples);
	// Where a quadric falls too steeply, far from the body, no corner tells whether it is inside. The planes do.
	uint32_t planes = samples.doubtful & F::less(-flush, top) & near;
	const uint32_t exact = F::less(samples.error, all(m_search.rounding)), zero = F::less(all(0), isQuarter ? top : top + misfit);
	const uint32_t asked = near & ~planes & ((zero & F::less(corners.least, all(0))) | (isQuarter ? 0 : exact));
	if (asked)
	{
		const F ofCorners = misfitOfCorners(e, corners);
		if constexpr (!isQuarter) planes |= asked & exact & F::less(all(kExactMisfit) * size, F::larger(misfit, ofCorners));
		misfit = F::select(asked, F::larger(misfit, ofCorners), misfit);
	}
	const uint32_t within = F::less(top, flush) & F::less(-flush, corners.least) & F::less(-flush, top) & ~planes & near;
	const uint32_t whole = ~F::less(corners.least, all(0)) & ~within & ~planes & near;
	uint32_t rim = zero & ~whole & ~within & ~planes & near;
	const uint32_t crease = rim & F::less(all(isQuarter ? kMostMisfit : kCreaseMisfit) * size, misfit);
	planes |= crease;
	rim &= ~crease;
	m_batch.planes |= planes << first;
	for (int k = 0; k < kLanes; ++k) m_batch.element[first + k] = index[k];
	if constexpr (isQuarter)
		for (int k = 0; k < kLanes; ++k) m_batch.quarter[first + k] = list[k] & 3;
	store(cellOf(samples.part), m_batch.cell + first);
	if constexpr (!isQuarter)
	{
		const uint32_t quartered = rim & F::less(all(kMostMisfit) * size, misfit);
		for (uint32_t b = quartered; b; b &= b - 1)
			for (uint32_t q = 0; q < 4; ++q) m_quarters.index[m_quarters.count++] = 4 * index[__builtin_ctz(b)] + q;
		rim &= ~quartered;
	}
	if (!(whole | within | rim)) return;

	uint32_t inside[4], exits[4];
	for (int i = 0; i < 4; ++i) inside[i] = ~F::less(corners.depth[i], all(0));
	for (int i = 0; i < 4; ++i) exits[i] = inside[i] & ~inside[(i + 1) % 4];
	const uint32_t once = (exits[0] ^ exits[1] ^ exits[2] ^ exits[3]) & ~(exits[0] & exits[2]) & ~(exits[1] & exits[3]);
	const uint32_t simple = rim & once & ~F::less(all(kMostBend) * corners.largest, absolute(bend)), cut = rim & ~simple;
	m_batch.faces |= (whole | within | simple) << first;
	m_batch.cut |= cut << first;
	put(FaceBatch::Gradient, first, samples.gradient);
	put(FaceBatch::E1, first, e.e1);
	put(FaceBatch::E2, first, e.e2);
	put(FaceBatch::NormalS, first, e.normalS);
	put(FaceBatch::NormalT, first, e.normalT);
	if (cut) putFrame(first, e, fit, flush);
	if (whole)
	{
		const RegionMoments m = wholeMoments(e);
		putFaces(first, e, m, fit, top, all(0), kAllLanes);
	}
	if (simple)
	{
		const CutEdges edges = cutEdges(fit, corners, inside);
		const RegionMoments m = insideMoments(e, edges, bulgeOf(fit, edges), inside);
		m_batch.faces &= ~((simple & ~F::less(all(kLeastShare), m.share)) << first);
		putFaces(first, e, m, fit, top, all(1), simple);
	}
	if (within) putFlush(first, e, corners.middle, flush, within);
}

IST_INLINE void FaceFinder::putFrame(int first, const ElementLanes& e, const DepthFit& fit, const F& flush)
{
	put(FaceBatch::Center, first, e.center);
	put(FaceBatch::Normal, first, e.normal);
	put(FaceBatch::Unit, first, e.unit);
	put(FaceBatch::K11, first, e.k11);
	put(FaceBatch::K12, first, e.k12);
	put(FaceBatch::K22, first, e.k22);
	put(FaceBatch::SignedArea, first, e.signedArea);
	const F numbers[6] = {fit.c, fit.cs, fit.ct, fit.css, fit.cst, fit.ctt};
	IST_UNROLL
	for (int i = 0; i < 6; ++i) put(FaceBatch::Depth + i, first, numbers[i]);
	put(FaceBatch::Flush, first, flush);
}

/// Integrals over a region of each element where the depth is positive. `top`: the largest depth. `cut`: 1 if the region was cut off at the
/// zero level, otherwise 0.
IST_INLINE void FaceFinder::putFaces(
	int first, const ElementLanes& e, const RegionMoments& m, const DepthFit& fit, const F& top, const F& cut, uint32_t lanes)
{
	const F half = all(0.5f);
	const F depth = fit.at(m.s, m.t) + half * (fit.css * m.varS + fit.ctt * m.varT) + fit.cst * m.cov;
	const F whole = m.share * e.area, area = whole * F::smaller(all(1), depth / (all(kLeastMean) * F::larger(top, all(1e-30f))));
	// First moments of the depth, from its tangent plane at the centroid.
	const F slopeS = fit.slopeS(m.s, m.t), slopeT = fit.slopeT(m.s, m.t);
	const F inverse = all(1) / F::larger(depth, all(1e-30f));
	// A depth that is negative on a part of the region could have it press outside: it stays within the element.
	const auto limited = [&](const F& shift, const F& centroid) __attribute__((always_inline))
	{
		return F::larger(F::smaller(shift, F::larger(all(1) - centroid, all(0))), F::smaller(all(-1) - centroid, all(0)));
	};
	const F shiftS = limited((slopeS * m.varS + slopeT * m.cov) * inverse, m.s),
			shiftT = limited((slopeS * m.cov + slopeT * m.varT) * inverse, m.t), ds = shiftS * depth, dt = shiftT * depth;
	const F height = (e.k11 + e.k22) * all(1 / 6.0f) - half * (e.k11 * (m.varS + m.s * m.s) + e.k22 * (m.varT + m.t * m.t)) -
		e.k12 * (m.cov + m.s * m.t);
	const F3 center = e.center + m.s * e.e1 + m.t * e.e2 + height * e.unit, normal = e.normal + m.s * e.normalS + m.t * e.normalT;
	put(FaceBatch::FaceCenter, first, center, lanes);
	put(FaceBatch::AreaNormal, first, area * normal, lanes);
	put(FaceBatch::Pressure, first, whole * (depth * normal + ds * e.normalS + dt * e.normalT), lanes);
	put(FaceBatch::PressureCenter, first, center + shiftS * e.e1 + shiftT * e.e2, lanes);
	put(FaceBatch::SpreadS, first, area * (m.varS * e.e1 + m.cov * e.e2), lanes);
	put(FaceBatch::SpreadT, first, area * (m.cov * e.e1 + m.varT * e.e2), lanes);
	put(FaceBatch::Area, first, area, lanes);
	put(FaceBatch::DepthIntegral, first, whole * depth, lanes);
	put(FaceBatch::CutArea, first, cut * area * (all(1) - m.share), lanes);
}

/// Elements that lie in the other surface, as far as the errors tell. Half of such an element counts as inside.
IST_INLINE void FaceFinder::putFlush(int first, const ElementLanes& e, const F& depth, const F& flush, uint32_t lanes)
{
	const F above = F::smaller(F::larger(depth + flush, all(0)), all(2) * flush), middle = e.pick(1 / 3.0f, 0), zero = all(0);
	const F area = e.area * above / (all(2) * flush), integral = all(0.5f) * above * area;
	const F3 center = e.center + middle * (e.e1 + e.e2), normal = e.normal + middle * (e.normalS + e.normalT), none{zero, zero, zero};
	put(FaceBatch::FaceCenter, first, center, lanes);
	put(FaceBatch::AreaNormal, first, area * normal, lanes);
	put(FaceBatch::Pressure, first, integral * normal, lanes);
	put(FaceBatch::PressureCenter, first, center, lanes);
	put(FaceBatch::SpreadS, first, none, lanes);
	put(FaceBatch::SpreadT, first, none, lanes);
	put(FaceBatch::Area, first, area, lanes);
	put(FaceBatch::DepthIntegral, first, integral, lanes);
	put(FaceBatch::CutArea, first, all(kFlushCut) * area, lanes);
}

void findFaces(FaceSearch& search) { FaceFinder(search).run(); }

void sampleDepths(const FieldTables& field, const DepthPoints& points)
{
	constexpr int kAtOnce = 4;
	for (int i = 0; i < points.count; i += kAtOnce * kLanes)
	{
		const int vectors = (points.count - i + kLanes - 1) / kLanes;
		F3 x[kAtOnce];
		Int part[kAtOnce];
		for (int p = 0; p < kAtOnce; ++p)
		{
			const int at = i + (p < vectors ? p * kLanes : 0);
			x[p] = {F::load(points.x + at), F::load(points.y + at), F::load(points.z + at)};
		}
		findParts(field, x, part);
		for (int p = 0; p < kAtOnce && p < vectors; ++p)
			F::larger(all(0), depthAt(field, part[p], x[p]).depth).store(points.depth + i + p * kLanes);
	}
}
}  // namespace
