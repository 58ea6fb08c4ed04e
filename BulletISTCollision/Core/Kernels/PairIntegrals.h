// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Kernels/Compressor.h"
#include "BulletISTCollision/Core/Kernels/EllipsoidLanes.h"

// Included by QueryKernel.cpp only. Offsets of centres are computed in double with the operations of the reference in their order, and so
// is all that decides whether two balls intersect. Two ellipsoids go on in floats: their depth in each other is good to some 2e-7 of
// their size.
namespace
{
using namespace ist;
using namespace ist::kernels;

using D = DoubleVector<kLanes>;

/// Pairs that are staged before they are summed; lane sums are floats within a stage, doubles beyond.
constexpr int kStage = 256;
constexpr float kPiF = 3.14159265358979323846f;

struct D3
{
	D x, y, z;
};
IST_INLINE D dot(const D3& a, const D3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// One vector of pairs. What does not intersect has mass and area zero.
struct Lenses
{
	uint32_t hits, meeting;
	F mass, area;      ///< dd L, dd times the disc's area
	F3 C, n, mA, mB;   ///< n: of unit length for balls; area times n is meant for all
	F depthA, depthB;  ///< at C
	F spread;          ///< s_ij in units of the query's typical volume
};

/// B's tree frame to A's, one component; the reference's order of operations.
IST_INLINE D moved(const PairBodies& bodies, int row, const D& x, const D& y, const D& z)
{
	return D::all(bodies.R[3 * row]) * x + D::all(bodies.R[3 * row + 1]) * y + D::all(bodies.R[3 * row + 2]) * z + D::all(bodies.t[row]);
}

/// What two balls share.
struct Shared
{
	uint32_t hits;
	F volume, disc, share;  ///< share: of the cap of ball j in the volume
	F whole;                ///< volume of the smaller ball
};

/// By radii, distance of the centres, and the signs and values of r_i + r_j - d, r_j - r_i + d and r_i - r_j + d.
IST_INLINE Shared sharedBy(const F& ri, const F& rj, const F& d, uint32_t overlapping, uint32_t apart, const F& overlap, const F& towardsI,
						   const F& towardsJ)
{
	const F small = F::smaller(ri, rj), zero = F::all(0);
	const F inverse = F::select(F::less(zero, d), F::all(1) / d, zero), half = F::all(0.5f) * overlap * inverse;
	const F hi = towardsI * half, hj = towardsJ * half;
	const F capI = F::all(kPiF / 3) * hi * hi * (F::all(3) * ri - hi), capJ = F::all(kPiF / 3) * hj * hj * (F::all(3) * rj - hj);
	Shared s;
	s.hits = F::less(zero, small) & (~apart | overlapping);
	s.whole = F::all(4 * kPiF / 3) * small * small * small;
	s.disc = F::select(apart, F::all(kPiF) * hi * (F::all(2) * ri - hi), zero);
	s.volume = F::select(apart, capI + capJ, s.whole);
	const F inside = F::select(~F::less(ri, rj), F::all(1), zero);
	s.share = F::select(apart & F::less(zero, s.volume), capJ / s.volume, inside);
	return s;
}

IST_INLINE Shared sharedByBalls(const D& Ri, const D& Rj, const D& distance)
{
	const D overlap = Ri + Rj - distance, towardsI = Rj - Ri + distance, towardsJ = Ri - Rj + distance;
	// Contained: the smaller radius exceeds neither difference. Rounding is monotonic, so these signs are exact.
	const uint32_t apart = D::less(D::all(0), towardsI) & D::less(D::all(0), towardsJ);
	return sharedBy(Ri.rounded(), Rj.rounded(), distance.rounded(), D::less(D::all(0), overlap), apart, overlap.rounded(), towardsI.rounded(),
					towardsJ.rounded());
}

/// P_i + P_j in units of the square of a power of two next to the reach, so that no power of a length leaves a float's range.
struct Whitening
{
	F unit, perUnit;  ///< that length; 1 over it
	F6 A, B;          ///< P_i, P_j
	F6 Q;             ///< adjugate of the sum
	F det;            ///< of the sum
};

/// Both in A's frame.
IST_INLINE Whitening whitening(const Balls& a, const Balls& b)
{
	Whitening w;
	w.unit = F::powerOfTwoBelow(a.R + b.R);
	w.perUnit = F::inverseOfPower(w.unit);
	const F unit = w.perUnit * w.perUnit;
	const auto scaled = [&](const F6& P) { return F6{P.xx * unit, P.yy * unit, P.zz * unit, P.xy * unit, P.xz * unit, P.yz * unit}; };
	w.A = scaled(a.shape);
	w.B = scaled(b.shape);
	const F6 P{w.A.xx + w.B.xx, w.A.yy + w.B.yy, w.A.zz + w.B.zz, w.A.xy + w.B.xy, w.A.xz + w.B.xz, w.A.yz + w.B.yz};
	w.Q = {P.yy * P.zz - P.yz * P.yz, P.xx * P.zz - P.xz * P.xz, P.xx * P.yy - P.xy * P.xy,
		   P.xz * P.yz - P.xy * P.zz, P.xy * P.yz - P.xz * P.yy, P.xy * P.xz - P.yz * P.xx};
	w.det = P.xx * w.Q.xx + P.xy * w.Q.xy + P.xz * w.Q.xz;
	return w;
}

/// The same of two ellipsoids, as the reference has it; disc times `n`: minus the gradient of the volume. Only where the bounds meet.
IST_INLINE Shared sharedByEllipsoids(const Balls& a, const Balls& b, const F3& offset, F3& n)
{
	const F zero = F::all(0), one = F::all(1);
	const Whitening white = whitening(a, b);
	const F6& Q = white.Q;
	const F u = white.perUnit, Ri = a.R * u, Rj = b.R * u, reach2 = (Ri + Rj) * (Ri + Rj);
	// One division for two.
	const F both = one / (white.det * reach2), inverse = both * reach2, perReach2 = both * white.det;
	// Each from its own shape: their squares add up to one, and the smaller would vanish in the rounding of the larger.
	const F third = inverse * F::all(1.0f / 3);
	const F ri = F::squareRoot(dot(white.A, Q) * third), rj = F::squareRoot(dot(white.B, Q) * third), sum = ri + rj;
	const F3 x{offset.x * u, offset.y * u, offset.z * u}, w = Q * x;
	const F own = dot(x, w) * inverse, share = sum * sum * perReach2, least = share * dot(x, x);
	const uint32_t bounded = F::less(own, least);
	const F d = F::squareRoot(F::larger(own, least));
	const F overlap = sum - d, towardsI = rj - ri + d, towardsJ = ri - rj + d;
	Shared s = sharedBy(ri, rj, d, F::less(zero, overlap), F::less(zero, towardsI) & F::less(zero, towardsJ), overlap, towardsI, towardsJ);

	const F length = Ri * Rj / (ri * rj) * white.unit, scale = length * length * length * F::squareRoot(inverse);
	const F steepness = F::select(F::less(zero, d), u / d, zero);
	const F alongOffset = F::select(bounded, share, zero) * steepness, alongW = F::select(bounded, zero, inverse) * steepness;
	const auto component = [&](const F& along, const F& wx) { return along * alongOffset + wx * alongW; };
	n = {component(x.x, w.x), component(x.y, w.y), component(x.z, w.z)};
	s.volume = s.volume * scale;
	s.whole = s.whole * scale;
	s.disc = s.disc * scale;
	return s;
}

template <Terms terms>
IST_INLINE Lenses lensesOf(const PairBodies& bodies, const uint32_t* indexA, const uint32_t* indexB, uint32_t real)
{
	const Balls a = fetch<terms>(bodies.ballsA, indexA);
	Balls b = fetch<terms>(terms == kLineTerms ? bodies.ballsB : bodies.movedB, indexB);
	// The centre once more: as it was moved, it has lost digits.
	if constexpr (terms != kLineTerms) fetchRow(bodies.ballsB, indexB, 0, b.x, b.y, b.z, b.R);
	const D bx = D::from(b.x), by = D::from(b.y), bz = D::from(b.z), Ri = D::from(a.R), Rj = D::from(b.R), reach = Ri + Rj;
	const D3 from{D::from(a.x) - moved(bodies, 0, bx, by, bz), D::from(a.y) - moved(bodies, 1, bx, by, bz),
				  D::from(a.z) - moved(bodies, 2, bx, by, bz)};
	const D squared = dot(from, from);
	const F3 offset{from.x.rounded(), from.y.rounded(), from.z.rounded()};
	const F zero = F::all(0);
	Lenses l;
	Shared shared;
	if constexpr (terms == kLineTerms)
	{
		const D distance = D::squareRoot(squared);
		shared = sharedByBalls(Ri, Rj, distance);
		const F d = distance.rounded(), inverse = F::select(F::less(zero, d), F::all(1) / d, zero);
		l.n = {offset.x * inverse, offset.y * inverse, offset.z * inverse};
	}
	else
		shared = sharedByEllipsoids(a, b, offset, l.n);
	l.meeting = real & D::less(squared, reach * reach);
	l.hits = l.meeting & shared.hits;
	const F dd = F::select(l.hits, a.density * b.density, zero);
	l.mass = F::select(l.hits, dd * shared.volume, zero);
	l.area = F::select(l.hits, dd * shared.disc, zero);
	l.C = {a.x - offset.x * shared.share, a.y - offset.y * shared.share, a.z - offset.z * shared.share};
	l.spread = F::select(l.hits, F::larger(zero, dd * F::smaller(shared.volume, shared.whole - shared.volume) * F::all(bodies.spreadUnit)), zero);
	if constexpr (terms != kLineTerms)
	{
		l.mA = a.normal;
		l.mB = b.normal;
		l.depthA = a.depth + shared.share * dot(l.mA, offset);
		l.depthB = b.depth - (F::all(1) - shared.share) * dot(l.mB, offset);
	}
	return l;
}

IST_INLINE uint32_t firstLanes(int count)
{
	return count >= kLanes ? (1u << kLanes) - 1 : (1u << count) - 1;
}

struct alignas(64) Stage
{
	float mass[kStage], area[kStage], C[3][kStage], n[3][kStage], mA[3][kStage], mB[3][kStage];
};

IST_INLINE void store3(float (*to)[kStage], int at, const F3& v)
{
	v.x.store(to[0] + at);
	v.y.store(to[1] + at);
	v.z.store(to[2] + at);
}
IST_INLINE F3 load3(const float (*from)[kStage], int at) { return {F::load(from[0] + at), F::load(from[1] + at), F::load(from[2] + at)}; }

template <int N>
IST_INLINE void addSums(double* sums, const F (&lanes)[N])
{
	for (int i = 0; i < N; ++i) sums[i] += lanes[i].sum();
}

/// Lenses of up to kStage pairs into the stage; sums what needs no second pass. Returns the staged length, whole vectors.
template <Terms terms>
int stagePairs(const PairBodies& bodies, const uint32_t* a, const uint32_t* b, int count, Stage& stage, double* sums)
{
	F depth[2] = {F::all(0), F::all(0)}, spread[1] = {F::all(0)};
	int64_t pairs = 0;
	int k = 0;
	for (; k < count; k += kLanes)
	{
		const Lenses l = lensesOf<terms>(bodies, a + k, b + k, firstLanes(count - k));
		l.mass.store(stage.mass + k);
		l.area.store(stage.area + k);
		store3(stage.C, k, l.C);
		store3(stage.n, k, l.n);
		if constexpr (terms != kLineTerms)
		{
			store3(stage.mA, k, l.mA);
			store3(stage.mB, k, l.mB);
			depth[0] += l.mass * l.depthA;
			depth[1] += l.mass * l.depthB;
		}
		spread[0] += l.spread * l.spread;
		pairs += __builtin_popcount(l.hits);
	}
	sums[kPairs] += double(pairs);
	addSums(sums + kSpread, spread);
	if constexpr (terms != kLineTerms) addSums(sums + kDepthA, depth);
	return k;
}

/// sum w m and sum C x (w m).
void sumWrench(const float* weight, const float (*m)[kStage], const Stage& stage, int length, double* sums)
{
	F s[6] = {F::all(0), F::all(0), F::all(0), F::all(0), F::all(0), F::all(0)};
	for (int k = 0; k < length; k += kLanes)
	{
		const F w = F::load(weight + k);
		const F3 v = load3(m, k), f{v.x * w, v.y * w, v.z * w}, turn = cross(load3(stage.C, k), f);
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
		const F mass = F::load(stage.mass + k), disc = F::load(stage.area + k);
		const F3 C = load3(stage.C, k), n = load3(stage.n, k), first{C.x * mass, C.y * mass, C.z * mass};
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

/// Three rows by four columns of the product g_n (g_wA, g_wB)^T: as many sums as fit into sixteen registers.
void sumTile(const float (*g)[kStage], const float (*w)[kStage], int length, double* product)
{
	F s[12];
	for (F& v : s) v = F::all(0);
	for (int k = 0; k < length; k += kLanes)
	{
		const F g0 = F::load(g[0] + k), g1 = F::load(g[1] + k), g2 = F::load(g[2] + k);
		IST_UNROLL
		for (int j = 0; j < 4; ++j)
		{
			const F wj = F::load(w[j] + k);
			s[j] += g0 * wj;
			s[4 + j] += g1 * wj;
			s[8 + j] += g2 * wj;
		}
	}
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 4; ++j) product[12 * i + j] += s[4 * i + j].sum();
}

struct alignas(64) Factors
{
	float g[6][kStage], w[12][kStage];
};

void sumStiffness(const Stage& stage, int length, Factors& factors, double* product)
{
	for (int k = 0; k < length; k += kLanes)
	{
		const F area = F::load(stage.area + k);
		const F3 C = load3(stage.C, k), n = load3(stage.n, k), mA = load3(stage.mA, k), mB = load3(stage.mB, k);
		const F3 g{area * n.x, area * n.y, area * n.z}, wA{-mA.x, -mA.y, -mA.z};
		store3(factors.g, k, g);
		store3(factors.g + 3, k, cross(C, g));
		store3(factors.w, k, wA);
		store3(factors.w + 3, k, cross(C, wA));
		store3(factors.w + 6, k, mB);
		store3(factors.w + 9, k, cross(C, mB));
	}
	for (int i = 0; i < 6; i += 3)
		for (int j = 0; j < 12; j += 4) sumTile(factors.g + i, factors.w + j, length, product + 12 * i + j);
}

template <Terms terms>
void evaluatePairs(const PairBodies& bodies, const uint32_t* a, const uint32_t* b, int count, double* sums)
{
	Stage stage;
	for (int first = 0; first < count; first += kStage)
	{
		const int rest = count - first < kStage ? count - first : kStage;
		const int length = stagePairs<terms>(bodies, a + first, b + first, rest, stage, sums);
		sumMoments(stage, length, sums);
		if constexpr (terms == kLineTerms)
			sumWrench(stage.mass, stage.n, stage, length, sums + kLine);
		else
		{
			sumWrench(stage.mass, stage.mA, stage, length, sums + kNormalA);
			sumWrench(stage.mass, stage.mB, stage, length, sums + kNormalB);
		}
		if constexpr (terms == kStiffnessTerms)
		{
			Factors factors;
			sumStiffness(stage, length, factors, sums + kProduct);
		}
	}
}

void evaluate(const PairBodies& bodies, const uint32_t* a, const uint32_t* b, int count, Terms terms, double* sums)
{
	switch (terms)
	{
		case kLineTerms: return evaluatePairs<kLineTerms>(bodies, a, b, count, sums);
		case kFieldTerms: return evaluatePairs<kFieldTerms>(bodies, a, b, count, sums);
		case kStiffnessTerms: return evaluatePairs<kStiffnessTerms>(bodies, a, b, count, sums);
	}
}

template <Terms terms>
int refinePairs(const PairBodies& bodies, const uint32_t* a, const uint32_t* b, int count, const PairStream& stream, int size)
{
	constexpr float kWeakNormal = 0.1f, kLeastWeight = 1e-3f;
	float* to[8] = {stream.fx, stream.fy, stream.fz, stream.size, stream.weight, stream.cx, stream.cy, stream.cz};
	for (int k = 0; k < count; k += kLanes)
	{
		const uint32_t real = firstLanes(count - k);
		const Lenses l = lensesOf<terms>(bodies, a + k, b + k, real);
		const F3 f = terms == kLineTerms ? F3{F::all(0), F::all(0), F::all(0)}
										 : F3{l.mass * (l.mB.x - l.mA.x), l.mass * (l.mB.y - l.mA.y), l.mass * (l.mB.z - l.mA.z)};
		const F length = F::squareRoot(dot(f, f)), strength = F::select(F::less(length, F::all(kWeakNormal) * l.mass), F::all(0), length);
		const F values[8] = {f.x, f.y, f.z, strength, F::larger(length, F::all(kLeastWeight) * l.mass), l.C.x, l.C.y, l.C.z};
		const uint32_t kept = bodies.keepMeeting ? l.meeting : l.hits;
		float lanes[8][kLanes];
		for (int i = 0; i < 8; ++i) values[i].store(lanes[i]);
		for (int part = 0; part < kLanes; part += kGroup)
		{
			const Compressor compressor(kept >> part & ((1u << kGroup) - 1));
			compressor.move(a + k + part, stream.a + size);
			compressor.move(b + k + part, stream.b + size);
			for (int i = 0; i < 8; ++i) compressor.move(lanes[i] + part, to[i] + size);
			size += compressor.count();
		}
	}
	return size;
}

int refine(const PairBodies& bodies, const uint32_t* a, const uint32_t* b, int count, Terms terms, const PairStream& stream, int size)
{
	return terms == kLineTerms ? refinePairs<kLineTerms>(bodies, a, b, count, stream, size)
							   : refinePairs<kFieldTerms>(bodies, a, b, count, stream, size);
}
}  // namespace
