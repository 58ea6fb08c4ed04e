// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Kernels/PairIntegrals.h"
#include "BulletISTCollision/Core/Kernels/PairSearch.h"

// Included by QueryKernel.cpp only. Half of the ellipsoids whose bounding balls meet are apart: a look at the distance alone, in floats
// and with some slack, spares them the rest.
namespace
{
/// `most`, times the determinant, for roots that grow by sqrt(2) margin over the root of the smallest eigenvalue.
IST_INLINE F extended(const F& most, const Whitening& w, const F& margin)
{
	const F step = F::squareRoot(F::all(2) * (w.Q.xx + w.Q.yy + w.Q.zz)) * margin, root = F::squareRoot(most) + step;
	return root * root;
}

/// In A's tree frame, in floats.
template <bool isMoved>
IST_INLINE Balls fetchMoved(const PairBodies& bodies, const uint32_t* index)
{
	if constexpr (isMoved) return fetchEllipsoids(bodies.movedB, index);
	Balls b = fetchEllipsoids(bodies.ballsB, index);
	const Centers c = movedCenters(bodies, b.x, b.y, b.z, b.R);
	b.x = c.x.rounded();
	b.y = c.y.rounded();
	b.z = c.z.rounded();
	b.shape = turned(bodies.R, b.shape);
	return b;
}

/// Bit k set where ellipsoids k may share volume, x^T (P_a + P_b)^-1 x < 2, within the margin. Over the directions u the root of the left side is
/// the largest u.x / h(u), h(u)^2 = u^T (P_a + P_b) u. Where no point of B moves by more than s, u.x and B's share in h change by |u| s together at
/// most, and h is at least |u| times the root of the smallest eigenvalue: a root of sqrt(2) was at most sqrt(2) s over the latter larger.
template <bool hasMargin, bool isMoved>
IST_INLINE uint32_t mayMeet(const PairBodies& bodies, const uint32_t* indexA, const uint32_t* indexB)
{
	const Balls a = fetchEllipsoids(bodies.ballsA, indexA), b = fetchMoved<isMoved>(bodies, indexB);
	const Whitening w = whitening(a, b);
	const F u = w.perUnit, slack = F::all(bodies.slack) * u;
	const F3 x{(a.x - b.x) * u, (a.y - b.y) * u, (a.z - b.z) * u};
	// Distances of the thinnest shapes err by .05 % in floats. The slack s moves the square root of the left side by at most s over the root of the smallest eigenvalue, and
	// (p + q)^2 <= 1.001 p^2 + 1001 q^2 without roots.
	const F most = F::all(2.0025f) * w.det + F::all(1001) * slack * slack * (w.Q.xx + w.Q.yy + w.Q.zz);
	const F reach = hasMargin ? extended(most, w, F::all(bodies.margin) * u) : most;
	return ~F::less(reach, dot(x, w.Q * x));
}

/// Drops pairs whose ellipsoids are apart from a list in place; returns the new length.
template <bool hasMargin, bool isMoved>
int siftPairs(const PairBodies& bodies, uint32_t* a, uint32_t* b, int count)
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

template <bool hasMargin>
int siftAs(const PairBodies& bodies, uint32_t* a, uint32_t* b, int count)
{
	return bodies.centersB ? siftPairs<hasMargin, true>(bodies, a, b, count) : siftPairs<hasMargin, false>(bodies, a, b, count);
}

int sift(const PairBodies& bodies, uint32_t* a, uint32_t* b, int count)
{
	return bodies.margin > 0 ? siftAs<true>(bodies, a, b, count) : siftAs<false>(bodies, a, b, count);
}
}  // namespace
