// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Kernels/PairIntegrals.h"
#include "BulletISTCollision/Core/Kernels/PairSearch.h"

// Included by QueryKernel.cpp only. Half of the ellipsoids whose bounding balls meet are apart: a look at the distance alone, in floats
// and with some slack, spares them the rest.
namespace
{
/// Bit k set where ellipsoids k may share volume: x^T (P_a + P_b)^-1 x < 2.
IST_INLINE uint32_t mayMeet(const PairBodies& bodies, const uint32_t* indexA, const uint32_t* indexB)
{
	const Balls a = fetchEllipsoids(bodies.ballsA, indexA), b = fetchEllipsoids(bodies.ballsB, indexB);
	const F3 own{b.x, b.y, b.z};
	const auto row = [&](int i) { return F3{F::all(float(bodies.R[3 * i])), F::all(float(bodies.R[3 * i + 1])), F::all(float(bodies.R[3 * i + 2]))}; };
	const F3 r0 = row(0), r1 = row(1), r2 = row(2);
	const F3 x{a.x - dot(r0, own) - F::all(float(bodies.t[0])), a.y - dot(r1, own) - F::all(float(bodies.t[1])),
			   a.z - dot(r2, own) - F::all(float(bodies.t[2]))};
	const Whitening w = whitening(bodies, a, b);
	const F slack = F::all(bodies.slack) * w.inverseReach;
	const F3 y{x.x * w.inverseReach, x.y * w.inverseReach, x.z * w.inverseReach};
	// The slack in the offset moves the square root of the left side by at most slack over the root of the smallest eigenvalue.
	const F3 Qy = w.Q * y;
	const F most = F::all(1.4143f) + slack * F::squareRoot(w.Q.xx + w.Q.yy + w.Q.zz) / F::squareRoot(w.det);
	return ~F::less(most * most * w.det, dot(y, Qy));
}

/// Drops pairs whose ellipsoids are apart from a list in place; returns the new length.
int sift(const PairBodies& bodies, uint32_t* a, uint32_t* b, int count)
{
	constexpr int kGroup = kLanes < 8 ? kLanes : 8;
	int kept = 0;
	for (int k = 0; k < count; k += kLanes)
	{
		const uint32_t bits = firstLanes(count - k) & mayMeet(bodies, a + k, b + k);
		for (int part = 0; part < kLanes; part += kGroup)
		{
			const Compressor compressor(bits >> part & ((1u << kGroup) - 1));
			compressor.move(a + k + part, a + kept);
			compressor.move(b + k + part, b + kept);
			kept += compressor.count();
		}
	}
	return kept;
}
}  // namespace
