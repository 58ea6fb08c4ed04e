// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Lens.h"
#include "BulletISTCollision/Core/OverlapQuery.h"

#include <algorithm>

namespace ist
{
namespace
{
/// The ball as Model::Inner counts it.
MomentBall packed(MomentBall ball)
{
	ball.nx = ball.ny = ball.nz = ball.depth = 0;
	return ball;
}

void addSymmetricProduct(SymmetricMatrix6& K, double factor, const Vec3& C, const Vec3& n, const Vec3& w)
{
	const Vec3 gn[2] = {n, cross(C, n)}, gw[2] = {w, cross(C, w)};
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j)
			K(i, j) += factor * 0.5 * (gn[i / 3][i % 3] * gw[j / 3][j % 3] + gn[j / 3][j % 3] * gw[i / 3][i % 3]);
}

void addPair(OverlapIntegrals& sums, const MomentBall& a, const MomentBall& b, const Vec3& centerB, const Mat3& R,
			 const Lens& lens)
{
	const double dd = double(a.density) * b.density, mass = dd * lens.volume;
	const Vec3 C = lens.centroid, mA = a.normal(), mB = R * b.normal();
	sums.pairs += 1;
	sums.volume += mass;
	sums.firstMoment += mass * C;
	const double products[6] = {C.x * C.x, C.y * C.y, C.z * C.z, C.x * C.y, C.x * C.z, C.y * C.z};
	for (int i = 0; i < 6; ++i) sums.secondMoment[i] += mass * products[i];
	sums.normalA = sums.normalA + mass * Wrench{mA, cross(C, mA)};
	sums.normalB = sums.normalB + mass * Wrench{mB, cross(C, mB)};
	sums.line = sums.line + mass * Wrench{lens.normal, cross(C, lens.normal)};
	sums.areaVector += dd * lens.area * lens.normal;
	addSymmetricProduct(sums.stiffnessA, dd * lens.area, C, lens.normal, -mA);
	addSymmetricProduct(sums.stiffnessB, dd * lens.area, C, lens.normal, mB);
	sums.depthA += mass * (a.depth - dot(mA, C - a.center()));
	sums.depthB += mass * (b.depth - dot(mB, C - centerB));
	const double small = ballVolume(std::min(a.R, b.R));
	const double s = dd * std::max(0.0, std::min(lens.volume, small - lens.volume));
	sums.spread += s * s;
}
}  // namespace

OverlapResult queryOverlapBruteForce(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, Model model)
{
	OverlapResult result;
	if (!isRigid(X_AB))
	{
		result.status = QueryStatus::InvalidPose;
		return result;
	}
	const BallTree& treeA = model == Model::Law ? A.law : model == Model::Cell ? A.cells : A.inner;
	const BallTree& treeB = model == Model::Law ? B.law : model == Model::Cell ? B.cells : B.inner;
	if (treeA.empty() || treeB.empty())
	{
		result.status = QueryStatus::EmptyTree;
		return result;
	}
	const Pose X{X_AB.rotation, X_AB.rotation * B.origin + (X_AB.translation - A.origin)};
	for (const MomentBall& b : treeB.balls)
	{
		const Vec3 centerB = X * b.center();
		for (const MomentBall& a : treeA.balls)
		{
			Lens lens;
			if (!lensOf(a.center(), a.R, centerB, b.R, lens)) continue;
			if (model == Model::Inner)
				addPair(result.total, packed(a), packed(b), centerB, X.rotation, lens);
			else
				addPair(result.total, a, b, centerB, X.rotation, lens);
			++result.ballTests;
		}
	}
	if (model != Model::Inner) result.total.line = {};
	return result;
}
}  // namespace ist
