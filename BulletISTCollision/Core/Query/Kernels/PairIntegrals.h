// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/Kernels/EllipsoidLanes.h"
#include "BulletISTCollision/Core/Query/Kernels/LaneCompressor.h"

#include <type_traits>

// Included by QueryKernel.cpp only. Offsets of centres are computed in double, with the reference's operations in the same order. So
// is everything that decides whether two balls intersect. The rest of the test of two ellipsoids is in floats: their depth in each other
// has an error of about 2e-7 of their size.
namespace
{
using namespace ist;
using namespace ist::kernels;

using Lanes = F::Lanes;

/// Number of pairs that are staged before they are summed. The sums of the lanes are floats within a stage, and doubles over all stages.
constexpr int kStage = 256;
constexpr float kPiF = 3.14159265358979323846f;

struct D3
{
	D x, y, z;
};
IST_INLINE D dot(const D3& a, const D3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// One vector of pairs. Pairs that do not intersect have zero mass and area.
struct Lenses
{
	Lanes hits, meeting;
	F mass, area;      ///< dd L, and dd times the area of the disc
	F3 C, n, mA, mB;   ///< n: unit length for balls only; area times n is the area vector for ellipsoids, too
	F depthA, depthB;  ///< depths at C
};

/// Transforms centres to A's tree frame.
IST_INLINE Centers movedCenters(const PairBodies& bodies, const F& x, const F& y, const F& z, const F& R)
{
	const D dx = D::from(x), dy = D::from(y), dz = D::from(z);
	const auto component = [&](int row) __attribute__((always_inline)) { return movedComponent(bodies.R, bodies.t, row, dx, dy, dz); };
	return {component(0), component(1), component(2), D::from(R)};
}

/// Intersection of two balls.
struct Shared
{
	Lanes hits;
	F volume, disc, share;  ///< share: share of the volume in the cap of ball j
	F inverse;              ///< 1 / distance of the centres, 0 where they coincide
	F squareI, squareJ;     ///< ellipsoids only: r_i^2 and r_j^2 in the coordinates in which lensOf compares them
};

/// Intersection of two balls of radii ri and rj at distance d.
/// `overlap`: r_i + r_j - d; `towardsI`: r_j - r_i + d; `towardsJ`: r_i - r_j + d.
/// `overlapping`: overlap > 0; `apart`: both others > 0, so that no ball contains the other.
IST_INLINE Shared sharedBy(const F& ri, const F& rj, const F& d, const Lanes& overlapping, const Lanes& apart, const F& overlap,
	const F& towardsI, const F& towardsJ)
{
	const F small = F::smaller(ri, rj), zero = F::all(0);
	Shared s;
	s.inverse = F::select(F::isLess(zero, d), F::all(1) / d, zero);
	const F half = F::all(0.5f) * overlap * s.inverse, hi = towardsI * half, hj = towardsJ * half;
	const F capI = F::all(kPiF / 3) * hi * hi * (F::all(3) * ri - hi), capJ = F::all(kPiF / 3) * hj * hj * (F::all(3) * rj - hj);
	s.hits = F::isLess(zero, small) & (~apart | overlapping);
	s.disc = F::select(apart, F::all(kPiF) * hi * (F::all(2) * ri - hi), zero);
	s.volume = F::select(apart, capI + capJ, F::all(4 * kPiF / 3) * small * small * small);
	const F inside = F::select(F::isLess(ri, rj), zero, F::all(1));
	s.share = F::select(apart & F::isLess(zero, s.volume), capJ / s.volume, inside);
	return s;
}

IST_INLINE Shared sharedByBalls(const D& Ri, const D& Rj, const D& distance)
{
	const D overlap = Ri + Rj - distance, towardsI = Rj - Ri + distance, towardsJ = Ri - Rj + distance;
	// A ball is contained where the smaller radius exceeds neither difference. These signs are exact because rounding is monotonic.
	const Lanes apart = D::isLess(D::all(0), towardsI) & D::isLess(D::all(0), towardsJ);
	return sharedBy(Ri.rounded(), Rj.rounded(), distance.rounded(), D::isLess(D::all(0), overlap), apart, overlap.rounded(),
		towardsI.rounded(), towardsJ.rounded());
}

/// P_i + P_j in units of u^2, where u is a power of two near the reach. So no power of a length leaves the range of a float.
struct Whitening
{
	F unit, perUnit, perUnit2;  ///< the unit of length, 1 over it, and the square of that
	F6 Q;                       ///< adjugate of the sum
	F det;                      ///< determinant of the sum
};

/// `a` and `b` are in A's frame.
IST_INLINE Whitening whitening(const Balls& a, const Balls& b)
{
	Whitening w;
	w.unit = F::powerOfTwoBelow(a.R + b.R);
	w.perUnit = F::inverseOfPower(w.unit);
	w.perUnit2 = w.perUnit * w.perUnit;
	const F6 P = w.perUnit2 * (a.shape + b.shape);
	w.Q = adjugate(P);
	w.det = determinant(P, w.Q);
	return w;
}

/// Intersection of two ellipsoids, computed as in the reference. Disc times `n` is the negative gradient of the volume. Valid only
/// where the bounding balls meet.
IST_INLINE Shared sharedByEllipsoids(const Balls& a, const Balls& b, const F3& offset, F3& n)
{
	const F zero = F::all(0), one = F::all(1);
	const Whitening white = whitening(a, b);
	const F6& Q = white.Q;
	const F u = white.perUnit, Ri = a.R * u, Rj = b.R * u, reach2 = (Ri + Rj) * (Ri + Rj);
	// One division gives both inverses.
	const F both = one / (white.det * reach2), inverse = both * reach2, perReach2 = both * white.det;
	// Each radius is computed from its own shape. Their squares add up to 1. As a difference the smaller one would be lost in the rounding
	// of the larger one.
	const F third = inverse * F::all(1.0f / 3) * white.perUnit2;
	const F ri = F::squareRoot(dot(a.shape, Q) * third), rj = F::squareRoot(dot(b.shape, Q) * third), sum = ri + rj;
	const F3 x{offset.x * u, offset.y * u, offset.z * u}, w = Q * x;
	const F own = dot(x, w) * inverse, share = sum * sum * perReach2, least = share * dot(x, x);
	const Lanes bounded = F::isLess(own, least);
	const F d = F::squareRoot(F::larger(own, least));
	const F overlap = sum - d, towardsI = rj - ri + d, towardsJ = ri - rj + d;
	Shared s = sharedBy(
		ri, rj, d, F::isLess(zero, overlap), F::isLess(zero, towardsI) & F::isLess(zero, towardsJ), overlap, towardsI, towardsJ);

	const F length = Ri * Rj / (ri * rj) * white.unit, scale = length * length * length * F::squareRoot(inverse);
	const F steepness = u * s.inverse;
	const F alongOffset = F::select(bounded, share, zero) * steepness, alongW = F::select(bounded, zero, inverse) * steepness;
	const auto component = [&](const F& along, const F& wx) { return along * alongOffset + wx * alongW; };
	n = {component(x.x, w.x), component(x.y, w.y), component(x.z, w.z)};
	s.squareI = ri * ri;
	s.squareJ = rj * rj;
	s.volume = s.volume * scale;
	s.disc = s.disc * scale;
	return s;
}

/// Loads B's balls in A's tree frame. Returns the centres, not rounded to floats; `b` receives the rest. `isMoved`: whether the search has
/// already transformed them.
template <Terms terms, bool isMoved> IST_INLINE Centers fetchB(const PairBodies& bodies, const uint32_t* index, Balls& b)
{
	if constexpr (isMoved)
	{
		const Centers c = fetchCenters(bodies.centersB, index);
		if constexpr (terms != kLineTerms) b = fetch(bodies.movedB, index);
		b.R = c.R.rounded();
		return c;
	}
	else
	{
		if constexpr (terms == kLineTerms) b = fetch(bodies.ballsB, index);
		else
		{
			b = fetch(bodies.ballsB, bodies.ellipsoidsB, index);
			b.normal = turned(bodies.R, b.normal);
			b.shape = turned(bodies.R, b.shape);
		}
		return movedCenters(bodies, b.x, b.y, b.z, b.R);
	}
}

template <Terms terms> IST_INLINE Balls fetchA(const PairBodies& bodies, const uint32_t* index)
{
	if constexpr (terms == kLineTerms) return fetch(bodies.ballsA, index);
	else return fetch(bodies.ballsA, bodies.ellipsoidsA, index);
}

/// Corrects lenses for normals that change over a ball of A, of B or of both. Sets the centroid, computed as in lensCentroid(), the
/// normals there and the depths there.
IST_INLINE void changeNormals(const PairBodies& bodies, const uint32_t* indexA, const uint32_t* indexB, const Balls& a, const Balls& b,
	const F3& offset, const Shared& shared, Lenses& l)
{
	// The sum of both shapes is scaled to a trace of 1. So its determinant stays in the range of a float, however different the two shapes
	// are.
	constexpr float kLeastTrace = 1e-37f;
	const F zero = F::all(0), one = F::all(1), ofA = shared.share * shared.squareJ, ofB = (one - shared.share) * shared.squareI;
	const F together = ofA * trace(a.shape) + ofB * trace(b.shape),
			scale = F::select(F::isLess(F::all(kLeastTrace), together), one / together, zero);
	const F6 A = (ofA * scale) * a.shape, B = (ofB * scale) * b.shape, N = A + B, Q = adjugate(N);
	const F det = determinant(N, Q);
	const F3 w = F::select(shared.hits & F::isLess(zero, det), one / det, zero) * (Q * offset), fromA = -one * (A * w), fromB = B * w;
	l.C = {a.x + fromA.x, a.y + fromA.y, a.z + fromA.z};
	l.depthA = a.depth - dot(l.mA, fromA);
	l.depthB = b.depth - dot(l.mB, fromB);
	if (bodies.gradientsA) l.mA = l.mA + fetch(bodies.gradientsA, indexA) * fromA;
	if (bodies.gradientsB) l.mB = l.mB + turned(bodies.R, fetch(bodies.gradientsB, indexB) * turnedBack(bodies.R, fromB));
}

/// `normalsChange`: whether normals change over the balls of A or of B.
template <Terms terms, bool isMoved, bool normalsChange>
IST_INLINE Lenses lensesOf(const PairBodies& bodies, const uint32_t* indexA, const uint32_t* indexB)
{
	Balls b;
	const Centers centers = fetchB<terms, isMoved>(bodies, indexB, b);
	const Balls a = fetchA<terms>(bodies, indexA);
	const D Ri = D::from(a.R), Rj = centers.R, reach = Ri + Rj;
	const D3 from{D::from(a.x) - centers.x, D::from(a.y) - centers.y, D::from(a.z) - centers.z};
	const D squared = dot(from, from);
	const F3 offset{from.x.rounded(), from.y.rounded(), from.z.rounded()};
	const F zero = F::all(0);
	Lenses l;
	Shared shared;
	if constexpr (terms == kLineTerms)
	{
		const D distance = D::squareRoot(squared);
		shared = sharedByBalls(Ri, Rj, distance);
		l.n = {offset.x * shared.inverse, offset.y * shared.inverse, offset.z * shared.inverse};
	}
	else shared = sharedByEllipsoids(a, b, offset, l.n);
	l.meeting = D::isLess(squared, reach * reach);
	l.hits = l.meeting & shared.hits;
	F density = F::all(1);
	if constexpr (terms != kLineTerms) density = a.density * b.density;
	const F dd = F::select(l.hits, density, zero);
	l.mass = F::select(l.hits, dd * shared.volume, zero);
	l.area = F::select(l.hits, dd * shared.disc, zero);
	l.C = {a.x - offset.x * shared.share, a.y - offset.y * shared.share, a.z - offset.z * shared.share};
	if constexpr (terms != kLineTerms)
	{
		// Copied component by component, because GCC copies a whole vector of three through memory.
		l.mA = {a.normal.x, a.normal.y, a.normal.z};
		l.mB = {b.normal.x, b.normal.y, b.normal.z};
		l.depthA = a.depth + shared.share * dot(l.mA, offset);
		l.depthB = b.depth - (F::all(1) - shared.share) * dot(l.mB, offset);
		if constexpr (normalsChange) changeNormals(bodies, indexA, indexB, a, b, offset, shared, l);
	}
	return l;
}

IST_INLINE uint32_t firstLanes(int count) { return count >= kLanes ? (1u << kLanes) - 1 : (1u << count) - 1; }

/// Pairs that are summed next. A column has kListSlack entries more than a power of two. Otherwise the same position in several
/// columns would compete for one cache set.
struct alignas(64) Stage
{
	static constexpr int kLength = kStage + kListSlack;
	float column[PairStream::Force][kLength];
};

/// Number of columns that sums of these terms need.
template <Terms terms> constexpr int kSummedColumns = terms == kLineTerms ? int(PairStream::MeanNormalA) : int(PairStream::Force);

/// Calls `visit(column, lanes)` for each of these columns.
template <Terms terms, class Visit> IST_INLINE void forEachColumn(const Lenses& l, const Visit& visit)
{
	const auto visit3 = [&](int column, const F3& v) __attribute__((always_inline))
	{
		visit(column, v.x);
		visit(column + 1, v.y);
		visit(column + 2, v.z);
	};
	visit(PairStream::Mass, l.mass);
	visit(PairStream::Area, l.area);
	visit3(PairStream::Centroid, l.C);
	visit3(PairStream::Normal, l.n);
	if constexpr (terms != kLineTerms)
	{
		visit3(PairStream::MeanNormalA, l.mA);
		visit3(PairStream::MeanNormalB, l.mB);
		visit(PairStream::DepthA, l.depthA);
		visit(PairStream::DepthB, l.depthB);
	}
}

IST_INLINE F3 load3(const Stage& stage, int column, int at)
{
	return {F::load(stage.column[column] + at), F::load(stage.column[column + 1] + at), F::load(stage.column[column + 2] + at)};
}

template <int N> IST_INLINE void addSums(double* sums, const F (&lanes)[N])
{
	for (int i = 0; i < N; ++i) sums[i] += lanes[i].sum();
}

/// Adds sum w m and sum C x (w m), where w is the mass.
void sumWrench(const Stage& stage, int m, int length, double* sums)
{
	F s[6] = {F::all(0), F::all(0), F::all(0), F::all(0), F::all(0), F::all(0)};
	for (int k = 0; k < length; k += kLanes)
	{
		const F w = F::load(stage.column[PairStream::Mass] + k);
		const F3 v = load3(stage, m, k), f{v.x * w, v.y * w, v.z * w}, turn = cross(load3(stage, PairStream::Centroid, k), f);
		s[0] += f.x;
		s[1] += f.y;
		s[2] += f.z;
		s[3] += turn.x;
		s[4] += turn.y;
		s[5] += turn.z;
	}
	addSums(sums, s);
}

void sumMoments(const Stage& stage, int length, double* sums)
{
	F s[10], area[3];
	for (F& v : s) v = F::all(0);
	for (F& v : area) v = F::all(0);
	for (int k = 0; k < length; k += kLanes)
	{
		const F mass = F::load(stage.column[PairStream::Mass] + k), disc = F::load(stage.column[PairStream::Area] + k);
		const F3 C = load3(stage, PairStream::Centroid, k), n = load3(stage, PairStream::Normal, k),
				 first{C.x * mass, C.y * mass, C.z * mass};
		s[0] += mass;
		s[1] += first.x;
		s[2] += first.y;
		s[3] += first.z;
		s[4] += first.x * C.x;
		s[5] += first.y * C.y;
		s[6] += first.z * C.z;
		s[7] += first.x * C.y;
		s[8] += first.x * C.z;
		s[9] += first.y * C.z;
		area[0] += disc * n.x;
		area[1] += disc * n.y;
		area[2] += disc * n.z;
	}
	static_assert(kFirst == kVolume + 1 && kSecond == kVolume + 4);
	addSums(sums + kVolume, s);
	addSums(sums + kArea, area);
}

void sumDepths(const Stage& stage, int length, double* sums)
{
	F depth[2] = {F::all(0), F::all(0)};
	for (int k = 0; k < length; k += kLanes)
	{
		const F mass = F::load(stage.column[PairStream::Mass] + k);
		depth[0] += mass * F::load(stage.column[PairStream::DepthA] + k);
		depth[1] += mass * F::load(stage.column[PairStream::DepthB] + k);
	}
	addSums(sums + kDepthA, depth);
}

/// Adds three rows of g times some columns of w to `product`, whose rows have `stride` entries. At most four columns: then the sums fit
/// into sixteen registers.
template <int kColumns> void sumTile(const float (*g)[kStage], const float (*w)[kStage], int length, double* product, int stride)
{
	F s[3 * kColumns];
	for (F& v : s) v = F::all(0);
	for (int k = 0; k < length; k += kLanes)
	{
		const F g0 = F::load(g[0] + k), g1 = F::load(g[1] + k), g2 = F::load(g[2] + k);
		IST_UNROLL
		for (int j = 0; j < kColumns; ++j)
		{
			const F wj = F::load(w[j] + k);
			s[j] += g0 * wj;
			s[kColumns + j] += g1 * wj;
			s[2 * kColumns + j] += g2 * wj;
		}
	}
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < kColumns; ++j) product[stride * i + j] += s[kColumns * i + j].sum();
}

struct alignas(64) Factors
{
	float g[6][kStage], w[12][kStage];
};

IST_INLINE void store3(float (*to)[kStage], int at, const F3& v)
{
	v.x.store(to[0] + at);
	v.y.store(to[1] + at);
	v.z.store(to[2] + at);
}

/// Adds the product g_n (g_wA, g_wB)^T.
void sumStiffness(const Stage& stage, int length, double* product)
{
	Factors factors;
	for (int k = 0; k < length; k += kLanes)
	{
		const F area = F::load(stage.column[PairStream::Area] + k);
		const F3 C = load3(stage, PairStream::Centroid, k), n = load3(stage, PairStream::Normal, k);
		const F3 mA = load3(stage, PairStream::MeanNormalA, k), mB = load3(stage, PairStream::MeanNormalB, k);
		const F3 g{area * n.x, area * n.y, area * n.z}, wA{-mA.x, -mA.y, -mA.z};
		store3(factors.g, k, g);
		store3(factors.g + 3, k, cross(C, g));
		store3(factors.w, k, wA);
		store3(factors.w + 3, k, cross(C, wA));
		store3(factors.w + 6, k, mB);
		store3(factors.w + 9, k, cross(C, mB));
	}
	for (int i = 0; i < 6; i += 3)
		for (int j = 0; j < 12; j += 4) sumTile<4>(factors.g + i, factors.w + j, length, product + 12 * i + j, 12);
}

/// Adds the products of G = (w, C x w) with itself. w is the direction in which a pair presses.
void sumDamping(const PairBodies& bodies, const Stage& stage, int length, double* product)
{
	Factors factors;
	const F weightA = F::all(bodies.weightA), weightB = F::all(bodies.weightB);
	for (int k = 0; k < length; k += kLanes)
	{
		const F mass = F::load(stage.column[PairStream::Mass] + k);
		const F3 C = load3(stage, PairStream::Centroid, k);
		const F3 mA = load3(stage, PairStream::MeanNormalA, k), mB = load3(stage, PairStream::MeanNormalB, k);
		const F3 w{weightB * mB.x - weightA * mA.x, weightB * mB.y - weightA * mA.y, weightB * mB.z - weightA * mA.z};
		const F3 turn = cross(C, w);
		store3(factors.w, k, w);
		store3(factors.w + 3, k, turn);
		store3(factors.g, k, {mass * w.x, mass * w.y, mass * w.z});
		store3(factors.g + 3, k, {mass * turn.x, mass * turn.y, mass * turn.z});
	}
	sumTile<3>(factors.g, factors.w, length, product, 3);
	sumTile<3>(factors.g, factors.w + 3, length, product + 9, 3);
	sumTile<3>(factors.g + 3, factors.w + 3, length, product + 18, 3);
}

/// `length`: a multiple of kLanes.
template <Terms terms> void sumStage(const PairBodies& bodies, const Stage& stage, int length, double* sums)
{
	sumMoments(stage, length, sums);
	if constexpr (terms == kLineTerms) sumWrench(stage, PairStream::Normal, length, sums + kLine);
	else
	{
		sumDepths(stage, length, sums);
		sumWrench(stage, PairStream::MeanNormalA, length, sums + kNormalA);
		sumWrench(stage, PairStream::MeanNormalB, length, sums + kNormalB);
	}
	if constexpr (terms == kStiffnessTerms) sumStiffness(stage, length, sums + kProduct);
	if constexpr (terms != kLineTerms)
		if (bodies.weightA > 0 || bodies.weightB > 0) sumDamping(bodies, stage, length, sums + kDamping);
}

/// Sums the first `length` staged pairs and empties the stage.
template <Terms terms> void flushStage(const PairBodies& bodies, Stage& stage, int& length, double* sums)
{
	for (int c = 0; c < kSummedColumns<terms>; ++c) F::all(0).store(stage.column[c] + length);
	sumStage<terms>(bodies, stage, (length + kLanes - 1) / kLanes * kLanes, sums);
	length = 0;
}

/// Appends those of the first `count` lanes that intersect. If at least three quarters do, it appends all lanes, because summing
/// zeros costs less than compressing.
template <Terms terms> IST_INLINE int stageLenses(const Lenses& l, int count, Stage& stage, int length)
{
	const uint32_t hits = l.hits.bits();
	forEachColumn<terms>(
		l, [&](int c, const F& v) __attribute__((always_inline)) { v.store(stage.column[c] + length); });
	if ((countLanes(hits) >= kLanes * 3 / 4) & (count >= kLanes)) return length + kLanes;
	// The columns are read back from memory. If they were kept in registers for this branch, they would be spilled on every path.
	const LaneCompressor kept(hits & firstLanes(count));
	for (int c = 0; c < kSummedColumns<terms>; ++c) kept.move(F::load(stage.column[c] + length), stage.column[c] + length);
	return length + kept.count();
}

template <Terms terms, bool isMoved, bool normalsChange>
void evaluatePairs(const PairBodies& bodies, const uint32_t* a, const uint32_t* b, int count, double* sums)
{
	Stage stage;
	int length = 0;
	int64_t pairs = 0;
	for (int k = 0; k < count; k += kLanes)
	{
		const Lenses l = lensesOf<terms, isMoved, normalsChange>(bodies, a + k, b + k);
		length = stageLenses<terms>(l, count - k, stage, length);
		pairs += countLanes(l.hits.bits() & firstLanes(count - k));
		if (length > kStage - kLanes) flushStage<terms>(bodies, stage, length, sums);
	}
	if (length > 0) flushStage<terms>(bodies, stage, length, sums);
	sums[kPairs] += double(pairs);
}

/// Calls `evaluate(isMoved, normalsChange)` with both as compile-time constants.
template <Terms terms, typename Evaluate> IST_INLINE auto specialized(const PairBodies& bodies, const Evaluate& evaluate)
{
	using Yes = std::true_type;
	using No = std::false_type;
	if constexpr (terms != kLineTerms)
	{
		if (bodies.gradientsA || bodies.gradientsB) return bodies.centersB ? evaluate(Yes(), Yes()) : evaluate(No(), Yes());
	}
	return bodies.centersB ? evaluate(Yes(), No()) : evaluate(No(), No());
}

template <Terms terms> void evaluateAs(const PairBodies& bodies, const uint32_t* a, const uint32_t* b, int count, double* sums)
{
	specialized<terms>(
		bodies, [&](auto isMoved, auto normalsChange) { evaluatePairs<terms, isMoved, normalsChange>(bodies, a, b, count, sums); });
}

void evaluate(const PairBodies& bodies, const uint32_t* a, const uint32_t* b, int count, Terms terms, double* sums)
{
	switch (terms)
	{
	case kLineTerms: return evaluateAs<kLineTerms>(bodies, a, b, count, sums);
	case kFieldTerms: return evaluateAs<kFieldTerms>(bodies, a, b, count, sums);
	case kStiffnessTerms: return evaluateAs<kStiffnessTerms>(bodies, a, b, count, sums);
	}
}
}  // namespace
