// SPDX-License-Identifier: Zlib
#include "tests/scenario/extremes/ExtremeTest.h"

#include "demos/scenes/Truth/PairMotion.h"

using namespace extremes;

namespace
{
constexpr double kHalf[3] = {0.1, 0.04, 0.075}, kMass = 0.2;

/// Amplitude by which a box rocks that was put down tilted. It is the standard deviation of the heights of its lower corners from the
/// fourth to the sixth second, over h^2 g. An explicit patch rocks by such a multiple, whatever its stiffness. `sinkage` is the sinkage at
/// rest, from stiffness times area [m].
double rocking(const ExtremeSolid& box, bool onBox, double sinkage, double h)
{
	ExtremeWorld world(Response::Volumetric, kGravity);
	const double area = 4 * kHalf[0] * kHalf[2], k = kMass * kGravity / (area * sinkage), inertia = kMass * kHalf[0] * kHalf[0] / 3;
	if (onBox) world.add(box, 0, 0, transformOf({0, -kHalf[1], 0}), 2 * k);
	else world.addFloor();
	btRigidBody* body = world.add(box, kMass, inertia, transformOf({0, kHalf[1] + 2e-3, 0}, {0.01, 0, 0.015}), onBox ? 2 * k : k);
	double sum[4] = {}, square[4] = {};
	int count = 0;
	for (int i = 0; i < int(6 / h); ++i)
	{
		world.step(h);
		if (i * h < 4) continue;
		++count;
		for (int corner = 0; corner < 4; ++corner)
		{
			const ist::Vec3 local{corner & 1 ? kHalf[0] : -kHalf[0], -kHalf[1], corner & 2 ? kHalf[2] : -kHalf[2]};
			const double y = (toPose(body->getWorldTransform()).rotation * local).y + positionOf(body).y;
			sum[corner] += y;
			square[corner] += y * y;
		}
	}
	double worst = 0;
	for (int corner = 0; corner < 4; ++corner)
	{
		const double mean = sum[corner] / count;
		worst = std::max(worst, std::sqrt(std::max(0.0, square[corner] / count - mean * mean)));
	}
	// It stands, possibly higher than its stiffness says, because leaves reach beyond each face by up to a gap.
	EXPECT_LT(std::fabs(positionOf(body).y - kHalf[1]), 0.2 * kHalf[1]);
	return worst / (h * h * kGravity);
}
}  // namespace

// The contact is flat, and the sinkage is much less than the fall of a body in one step. One edge touches at a time, and the other one is
// known only in the next step. This keeps an explicit contact rocking by 0.1 to 0.6 of h^2 g. Patches that resist tilting within the step
// come to rest without a collision margin.
TEST(Rocking, BoxThatWasPutDownTiltedComesToRestWithoutAMargin)
{
	const ExtremeSolid box = solidOf(ist::makeBoxMesh({kHalf[0], kHalf[1], kHalf[2]}), 2000);
	for (const bool onBox : {false, true})
		for (const double h : {1.0 / 60, 0.01})
			for (const double sinkage : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7})
			{
				const double rocks = rocking(box, onBox, sinkage, h);
				std::printf("  on a %s, step %.4f s, sinkage %.0e m: rocks by %.1e h^2 g\n", onBox ? "box" : "plane", h, sinkage, rocks);
				EXPECT_LT(rocks, 2e-3) << onBox << " " << h << " " << sinkage;
			}
}
