// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/Kernels/PairIntegrals.h"
#include "BulletISTCollision/Core/Query/Kernels/PairSearch.h"

// Included by QueryKernel.cpp only. Half of the ellipsoids whose bounding balls meet are apart. This distance test in floats, with
// some slack, saves their full evaluation.
namespace
{
/// Enlarges P so that its ellipsoid contains all points within m = `margin` of the ellipsoid of P. With h^2 = u^T P u in a direction u,
///     (h + m)^2 <= (1 + t) h^2 + (1 + 1/t) m^2.
/// Both sides are equal where t = m / h; here t uses the mean h.
IST_INLINE F6 grown(const F6& P, const F& margin)
{
	const F mean = F::squareRoot((P.xx + P.yy + P.zz) * F::all(1.0f / 3));
	const F wider = F::all(1) + margin / mean, rest = margin * (mean + margin);
	return {P.xx * wider + rest, P.yy * wider + rest, P.zz * wider + rest, P.xy * wider, P.xz * wider, P.yz * wider};
}

IST_INLINE F determinant(const F6& M)
{
	const F x = negatedMultiplyAdd(M.yz, M.yz, M.yy * M.zz), y = negatedMultiplyAdd(M.yz, M.xz, M.xy * M.zz),
			z = negatedMultiplyAdd(M.yy, M.xz, M.xy * M.yz);
	return multiplyAdd(M.xz, z, negatedMultiplyAdd(M.xy, y, M.xx * x));
}

/// Loads balls of B in A's tree frame, in floats.
template <bool isMoved> IST_INLINE Balls fetchMoved(const PairBodies& bodies, const uint32_t* index)
{
	if constexpr (isMoved) return fetchShapes(bodies.movedB, index);
	Balls b = fetchShapes(bodies.ballsB, bodies.ellipsoidsB, index);
	const Centers c = movedCenters(bodies, b.x, b.y, b.z, b.R);
	b.x = c.x.rounded();
	b.y = c.y.rounded();
	b.z = c.z.rounded();
	b.shape = turned(bodies.R, b.shape);
	return b;
}

/// Bit k is set where the ellipsoids k may intersect, within the margin.
/// Ellipsoids at the offset x can intersect only if x^T P^-1 x < 2 with P = P_a + P_b. This means u.x < sqrt(2) h(u) in all directions u,
/// with h(u)^2 = u^T P u.
/// If points of B move by at most s, u.x and B's part of h together change by at most |u| s. So u.x was below sqrt(2) (h + |u| s) before.
/// The condition holds where the determinant of 2 P - x x^T is positive, because it equals det(2 P) (1 - x^T P^-1 x / 2).
template <bool hasMargin, bool isMoved>
IST_INLINE uint32_t mayMeet(const PairBodies& bodies, const uint32_t* indexA, const uint32_t* indexB)
{
	const Balls a = fetchShapes(bodies.ballsA, bodies.ellipsoidsA, indexA), b = fetchMoved<isMoved>(bodies, indexB);
	const F6 &A = a.shape, &B = b.shape;
	F6 P{A.xx + B.xx, A.yy + B.yy, A.zz + B.zz, A.xy + B.xy, A.xz + B.xz, A.yz + B.yz};
	if constexpr (hasMargin) P = grown(P, F::all(bodies.margin));
	// Distances of the thinnest shapes err by 0.05 % in floats. The slack s changes u.x by at most |u| s, and (p + q)^2 <= 1.001 p^2 +
	// 1001 q^2. So the matrix is 2.0025 P + 1001 s^2 - x x^T, here divided by 2.0025.
	constexpr float kPerRoot = 0.70666f, kSlackPerRoot = 22.358f;  // 1 and sqrt(1001), over sqrt(2.0025)
	const F perUnit = F::inverseOfPower(F::powerOfTwoBelow(a.R + b.R)), u2 = perUnit * perUnit;
	const F u = perUnit * F::all(kPerRoot), slack = perUnit * F::all(kSlackPerRoot * bodies.slack), slack2 = slack * slack;
	const F3 x{(a.x - b.x) * u, (a.y - b.y) * u, (a.z - b.z) * u};
	const auto side = [&](const F& p, const F& v) __attribute__((always_inline))
	{
		return negatedMultiplyAdd(v, v, multiplyAdd(p, u2, slack2));
	};
	const auto corner = [&](const F& p, const F& v, const F& w) __attribute__((always_inline)) { return negatedMultiplyAdd(v, w, p * u2); };
	const F6 rest{
		side(P.xx, x.x), side(P.yy, x.y), side(P.zz, x.z), corner(P.xy, x.x, x.y), corner(P.xz, x.x, x.z), corner(P.yz, x.y, x.z)};
	return ~F::less(determinant(rest), F::all(0));
}

/// Drops, in place, pairs whose ellipsoids are apart. Returns the new length.
template <bool hasMargin, bool isMoved> int cullPairs(const PairBodies& bodies, uint32_t* a, uint32_t* b, int count)
{
	int kept = 0;
	for (int k = 0; k < count; k += kLanes)
	{
		const uint32_t bits = firstLanes(count - k) & mayMeet<hasMargin, isMoved>(bodies, a + k, b + k);
		const LaneCompressor compressor(bits);
		compressor.move(a + k, a + kept);
		compressor.move(b + k, b + kept);
		kept += compressor.count();
	}
	return kept;
}

template <bool hasMargin> int cullAs(const PairBodies& bodies, uint32_t* a, uint32_t* b, int count)
{
	return bodies.centersB ? cullPairs<hasMargin, true>(bodies, a, b, count) : cullPairs<hasMargin, false>(bodies, a, b, count);
}

int cull(const PairBodies& bodies, uint32_t* a, uint32_t* b, int count)
{
	return bodies.margin > 0 ? cullAs<true>(bodies, a, b, count) : cullAs<false>(bodies, a, b, count);
}
}  // namespace
