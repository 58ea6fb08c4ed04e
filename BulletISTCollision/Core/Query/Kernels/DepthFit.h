// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/Kernels/ElementLanes.h"

// Included by QueryKernel.cpp only. The depth over elements, and the parts of elements where it is positive.
namespace
{
/// The depth as a quadratic function of an element's coordinates: c + cs s + ct t + (css s^2 + 2 cst s t + ctt t^2) / 2.
struct DepthFit
{
	F c, cs, ct, css, cst, ctt;

	IST_INLINE F at(const F& s, const F& t) const
	{
		const F half = all(0.5f);
		return c + s * (cs + half * css * s + cst * t) + t * (ct + half * ctt * t);
	}
	IST_INLINE F slopeS(const F& s, const F& t) const { return cs + css * s + cst * t; }
	IST_INLINE F slopeT(const F& s, const F& t) const { return ct + cst * s + ctt * t; }
};

constexpr float kGauss = 0.57735026919f;  // 1 / sqrt(3)

/// Square of a slope: that of a depth is about 1.
constexpr float kSteep = 2;

/// The depth at four points of each element, with its derivatives along s and t on the sheet.
struct DepthSamples
{
	F s[4], t[4];
	F depth[4], slopeS[4], slopeT[4];
	F3 gradient;        ///< mean
	F error;            ///< largest error of a cell
	Int part;           ///< of the first point
	uint32_t astray;    ///< nothing of the body is at any of the points, and a quadric is not even negative there: it says nothing
	uint32_t doubtful;  ///< nothing of the body is there, and a quadric is too far from its samples, or steeper than a depth
};

/// Walks down the partition from the starts of `count` points at once, which hides the latency of the loads.
template <int count> IST_INLINE void findParts(const FieldTables& s, const F3 (&x)[count], Int (&part)[count])
{
	_Pragma("GCC unroll 1") for (int p = 0; p < count; ++p) part[p] = startAt(s, x[p]);
	for (bool open = true; open;)
	{
		open = false;
		_Pragma("GCC unroll 1") for (int p = 0; p < count; ++p) if (anyNotNegative(part[p]))
		{
			descend(s, part[p], x[p]);
			open = true;
		}
	}
}

/// The depth at points. Where nothing of the body is, it is at most zero.
IST_INLINE DepthLanes depthAt(const FieldTables& s, Int part, const F3& x)
{
	DepthLanes d = depthIn(fetchCells(s, part), x);
	d.outside |= isOutside(part);
	d.depth = F::select(d.outside, F::smaller(d.depth, all(0)), d.depth);
	return d;
}

/// Samples at the points of Gauss's quadrature: two by two in a parallelogram, three in a triangle, whose fourth is the centroid.
IST_INLINE void sampleDepth(const FaceSearch& search, const ElementLanes& e, DepthSamples& d)
{
	const F low = e.pick(1 / 6.0f, -kGauss), high = e.pick(2 / 3.0f, kGauss);
	d.s[0] = d.t[0] = d.t[1] = low;
	d.s[1] = d.t[2] = high;
	d.s[2] = e.pick(1 / 6.0f, kGauss);
	d.s[3] = e.pick(1 / 3.0f, -kGauss);
	d.t[3] = e.pick(1 / 3.0f, kGauss);
	F3 x[4];
	Int part[4];
	_Pragma("GCC unroll 1") for (int p = 0; p < 4; ++p)
		x[p] = e.center + d.s[p] * e.e1 + d.t[p] * e.e2 + (e.k12 * all(p & 1 ? 1 / 3.0f : -1 / 3.0f)) * e.unit;
	findParts(search, x, part);
	d.gradient = {all(0), all(0), all(0)};
	d.error = all(0);
	uint32_t outside = kAllLanes, raised = 0, doubtful = 0;
	_Pragma("GCC unroll 1") for (int p = 0; p < 4; ++p)
	{
		const DepthLanes at = depthAt(search, part[p], x[p]);
		// Where nothing of the body is, surfaces do not lie in each other either.
		const F apart = all(-kFlushErrors) * (at.error + e.error) - all(2 * search.rounding);
		d.depth[p] = F::select(at.outside, F::smaller(at.depth, apart), at.depth);
		outside &= at.outside;
		raised |= at.outside & ~F::less(at.depth, apart);
		doubtful |= at.far | F::less(all(kSteep), dot(at.gradient, at.gradient));
		d.error = F::larger(d.error, at.error);
		d.gradient = d.gradient + at.gradient;
		const F slope = dot(at.gradient, e.unit);
		d.slopeS[p] = dot(at.gradient, e.e1) - slope * (e.k11 * d.s[p] + e.k12 * d.t[p]);
		d.slopeT[p] = dot(at.gradient, e.e2) - slope * (e.k12 * d.s[p] + e.k22 * d.t[p]);
	}
	d.gradient = all(0.25f) * d.gradient;
	d.astray = outside & raised;
	d.doubtful = outside & doubtful;
	d.part = part[0];
}

IST_INLINE DepthFit fitOf(const ElementLanes& e, const DepthSamples& d)
{
	const F(&v)[4] = d.depth, (&gs)[4] = d.slopeS, (&gt)[4] = d.slopeT;
	const F quarter = all(0.25f / kGauss), two = all(2), sixth = all(1 / 6.0f);
	const auto either = [&](const F& forTriangle, const F& forParallelogram) __attribute__((always_inline))
	{
		return F::select(e.triangle, forTriangle, forParallelogram);
	};
	DepthFit f;
	f.css = either(two * (gs[1] - gs[0]), quarter * (gs[1] + gs[2] - gs[0] - gs[3]));
	f.ctt = either(two * (gt[2] - gt[0]), quarter * (gt[2] + gt[3] - gt[0] - gt[1]));
	f.cst = either(gt[1] - gt[0] + gs[2] - gs[0], all(0.75f) * (v[0] + v[2] - v[1] - v[3]));
	f.cs = either(two * (v[1] - v[0]) - all(5 / 12.0f) * f.css - sixth * f.cst, quarter * (v[1] + v[2] - v[0] - v[3]));
	f.ct = either(two * (v[2] - v[0]) - all(5 / 12.0f) * f.ctt - sixth * f.cst, quarter * (v[2] + v[3] - v[0] - v[1]));
	f.c = either(v[0] - sixth * (f.cs + f.ct) - all(1 / 72.0f) * (f.css + f.ctt + two * f.cst),
		all(0.25f) * (v[0] + v[1] + v[2] + v[3]) - sixth * (f.css + f.ctt));
	return f;
}

/// How far the samples are from one quadratic function [m].
IST_INLINE F misfitOf(const ElementLanes& e, const DepthSamples& d)
{
	F misfit = all(0);
	const auto compare = [&](int i, int j, const F(&slope)[4], const F& share) __attribute__((always_inline))
	{
		misfit = F::larger(misfit, absolute(d.depth[j] - d.depth[i] - share * (slope[i] + slope[j])));
	};
	// The corners of a triangle's samples have only one edge along s; the others compare the depths themselves.
	const F step = e.pick(0.25f, kGauss), others = e.pick(0, kGauss);
	compare(0, 1, d.slopeS, step);
	compare(3, 2, d.slopeS, others);
	compare(0, 3, d.slopeT, others);
	compare(1, 2, d.slopeT, others);
	return misfit;
}

/// The depth at the corners and at the middle. The fourth corner of a triangle is its third once more.
struct CornerDepths
{
	F s[4], t[4], depth[4];
	F middle, mean, least, largest;  ///< `mean`: of the corners; `least` and `largest`: of corners and middle
};

IST_INLINE CornerDepths cornersOf(const ElementLanes& e, const DepthFit& fit)
{
	CornerDepths c;
	const F low = e.pick(0, -1), high = e.pick(0, 1), middle = e.pick(1 / 3.0f, 0);
	c.s[0] = c.s[3] = c.t[0] = c.t[1] = low;
	c.s[1] = c.t[2] = c.t[3] = all(1);
	c.s[2] = high;
	IST_UNROLL
	for (int i = 0; i < 4; ++i) c.depth[i] = fit.at(c.s[i], c.t[i]);
	const F(&w)[4] = c.depth;
	c.middle = fit.at(middle, middle);
	c.least = F::smaller(F::smaller(F::smaller(w[0], w[1]), F::smaller(w[2], w[3])), c.middle);
	c.largest = F::larger(F::larger(F::larger(w[0], w[1]), F::larger(w[2], w[3])), c.middle);
	c.mean = F::select(e.triangle, all(1 / 3.0f) * (w[0] + w[1] + w[2]), all(0.25f) * (w[0] + w[1] + w[2] + w[3]));
	return c;
}

/// Share of a region in its element, its centroid and its central second moments, in coordinates.
struct RegionMoments
{
	F share, s, t, varS, varT, cov;
};

IST_INLINE RegionMoments wholeMoments(const ElementLanes& e)
{
	const F middle = e.pick(1 / 3.0f, 0), var = e.pick(1 / 18.0f, 1 / 3.0f);
	return {all(1), middle, middle, var, var, e.pick(-1 / 36.0f, 0)};
}

/// Edges of elements, cut where the depth is zero.
struct CutEdges
{
	F beginS[4], beginT[4], endS[4], endT[4];
	F exitS, exitT, entryS, entryT;  ///< where the boundary leaves the inside and comes back
};

/// `inside[i]`: bit k is set if corner i of element k is inside. The cuts are the roots of the depth on the edges: those of the chord,
/// improved by a step of Newton's method.
IST_INLINE CutEdges cutEdges(const DepthFit& fit, const CornerDepths& c, const uint32_t (&inside)[4])
{
	CutEdges e;
	e.exitS = e.entryS = c.s[0];
	e.exitT = e.entryT = c.t[0];
	IST_UNROLL
	for (int i = 0; i < 4; ++i)
	{
		const int j = (i + 1) % 4;
		const uint32_t crosses = inside[i] ^ inside[j];
		const F w = c.depth[i], rise = c.depth[j] - w;
		const F half = fit.at(all(0.5f) * (c.s[i] + c.s[j]), all(0.5f) * (c.t[i] + c.t[j]));
		const F bend = all(2) * (w + c.depth[j]) - all(4) * half;
		const F chord = -w / F::select(crosses, rise, all(1));
		const F slope = rise + bend * (chord + chord - all(1)), least = all(0.3f) * rise;
		const F steep = F::select(inside[i], F::smaller(slope, least), F::larger(slope, least));
		const F root = chord - bend * chord * (chord - all(1)) / F::select(crosses, steep, all(1));
		const F u = F::larger(all(0), F::smaller(all(1), root));
		const F s = c.s[i] + u * (c.s[j] - c.s[i]), t = c.t[i] + u * (c.t[j] - c.t[i]);
		e.beginS[i] = F::select(inside[i], c.s[i], s);
		e.beginT[i] = F::select(inside[i], c.t[i], t);
		e.endS[i] = F::select(inside[j], c.s[j], s);
		e.endT[i] = F::select(inside[j], c.t[j], t);
		const uint32_t exits = inside[i] & ~inside[j], enters = inside[j] & ~inside[i];
		e.exitS = F::select(exits, s, e.exitS);
		e.exitT = F::select(exits, t, e.exitT);
		e.entryS = F::select(enters, s, e.entryS);
		e.entryT = F::select(enters, t, e.entryT);
	}
	return e;
}

struct Coordinates
{
	F s, t;
};

/// A point beyond the middle of the chord from the exit to the entry. The triangle of the three has the area between the chord and the
/// zero level, which is taken as a parabola.
IST_INLINE Coordinates bulgeOf(const DepthFit& fit, const CutEdges& e)
{
	const F half = all(0.5f), s = half * (e.exitS + e.entryS), t = half * (e.exitT + e.entryT);
	const F slopeS = fit.slopeS(s, t), slopeT = fit.slopeT(s, t), squared = slopeS * slopeS + slopeT * slopeT;
	const F depth = fit.at(s, t), limit = half * (absolute(e.entryS - e.exitS) + absolute(e.entryT - e.exitT));
	const F step = all(4 / 3.0f) * depth / F::larger(squared, all(1e-30f));
	const F::Lanes small = F::isLess(depth * depth, limit * limit * squared);
	return {s - F::select(small, step * slopeS, all(0)), t - F::select(small, step * slopeT, all(0))};
}

/// Moments of the part where the depth is positive, for elements whose boundary the zero level crosses twice. By Green's theorem about
/// the exit, so that the edge from there contributes nothing.
IST_INLINE RegionMoments insideMoments(
	const ElementLanes& element, const CutEdges& e, const Coordinates& bulge, const uint32_t (&inside)[4])
{
	F m0 = all(0), ms = m0, mt = m0, mss = m0, mst = m0, mtt = m0;
	const auto addEdge = [&](const F& beginS, const F& beginT, const F& endS, const F& endT, uint32_t lanes) __attribute__((always_inline))
	{
		const F as = beginS - e.exitS, at = beginT - e.exitT, bs = endS - e.exitS, bt = endT - e.exitT;
		const F w = F::select(lanes, as * bt - bs * at, all(0));
		m0 += w;
		ms += w * (as + bs);
		mt += w * (at + bt);
		mss += w * (as * as + as * bs + bs * bs);
		mtt += w * (at * at + at * bt + bt * bt);
		mst += w * (as * at + bs * bt + all(0.5f) * (as * bt + bs * at));
	};
	IST_UNROLL
	for (int i = 0; i < 4; ++i) addEdge(e.beginS[i], e.beginT[i], e.endS[i], e.endT[i], inside[i] | inside[(i + 1) % 4]);
	// A bulge into a sliver may leave it: no area is left then, and its centroid is anywhere.
	const F added = (bulge.s - e.exitS) * (e.entryT - e.exitT) - (e.entryS - e.exitS) * (bulge.t - e.exitT);
	addEdge(bulge.s, bulge.t, e.entryS, e.entryT, F::less(all(-0.5f) * m0, added));
	const F area = all(0.5f) * m0, inverse = all(1) / F::larger(area, all(1e-20f)), twelfth = all(1 / 12.0f) * inverse;
	const F s = all(1 / 6.0f) * ms * inverse, t = all(1 / 6.0f) * mt * inverse;
	return {area * element.pick(2, 0.25f), e.exitS + s, e.exitT + t, twelfth * mss - s * s, twelfth * mtt - t * t, twelfth * mst - s * t};
}
}  // namespace
