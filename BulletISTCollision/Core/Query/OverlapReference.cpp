// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Geometry/Lens.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Query/QueryWorkspaceState.h"

#include <algorithm>

namespace ist
{
namespace
{
struct Piece
{
	MomentEllipsoid ball;
	SymmetricMatrix3 gradient;  ///< gradient of the normal over the ball
};

/// Ball as Model::Inner uses it: without normal and depth.
Piece packed(MomentEllipsoid ball)
{
	ball.nx = ball.ny = ball.nz = ball.depth = 0;
	return {ball, {}};
}

Piece pieceOf(const BallTree& tree, size_t slot, Model model)
{
	return model == Model::Inner ? packed(tree.ball(slot)) : Piece{tree.ball(slot), tree.gradient(slot).matrix()};
}

void addSymmetricProduct(SymmetricMatrix6& K, double factor, const Vec3& C, const Vec3& n, const Vec3& w)
{
	const Vec3 gn[2] = {n, cross(C, n)}, gw[2] = {w, cross(C, w)};
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j) K(i, j) += factor * 0.5 * (gn[i / 3][i % 3] * gw[j / 3][j % 3] + gn[j / 3][j % 3] * gw[i / 3][i % 3]);
}

void addDamping(OverlapIntegrals& sums, double mass, const Vec3& C, const Vec3& mA, const Vec3& mB)
{
	const Vec3 w = sums.dampingWeights.B * mB - sums.dampingWeights.A * mA;
	addSymmetricProduct(sums.damping, mass, C, w, w);
}

void addPair(OverlapIntegrals& sums, const Piece& pieceA, const Piece& pieceB, const Vec3& centerB, const Mat3& R, const Lens& lens)
{
	const MomentEllipsoid &a = pieceA.ball, &b = pieceB.ball;
	const double dd = double(a.density) * b.density, mass = dd * lens.volume;
	const Vec3 C = lens.centroid;
	const Vec3 mA = a.normal() + pieceA.gradient * (C - a.center()),
			   mB = R * (b.normal() + pieceB.gradient * (transpose(R) * (C - centerB)));
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
	addDamping(sums, mass, C, mA, mB);
	sums.depthA += mass * (a.depth - dot(a.normal(), C - a.center()));
	sums.depthB += mass * (b.depth - dot(R * b.normal(), C - centerB));
}

bool addBalls(OverlapIntegrals& sums, const Piece& a, const Piece& b, const Vec3& centerB, const Mat3& R)
{
	Lens lens;
	if (!lensOf(a.ball.center(), a.ball.R, centerB, b.ball.R, lens)) return false;
	addPair(sums, a, b, centerB, R, lens);
	return true;
}

/// `normalsChange`: whether normals change over the balls of A or B.
bool addEllipsoids(OverlapIntegrals& sums, const Piece& a, const Piece& b, const Vec3& centerB, const SymmetricMatrix3& shapeB,
	const Mat3& R, bool normalsChange)
{
	Lens lens;
	if (!lensOf(a.ball.center(), a.ball.R, a.ball.shape(), centerB, b.ball.R, shapeB, lens)) return false;
	if (normalsChange) lens.centroid = lensCentroid(lens, a.ball.center(), a.ball.shape(), centerB, shapeB);
	addPair(sums, a, b, centerB, R, lens);
	return true;
}
}  // namespace

OverlapResult queryOverlapBruteForce(
	const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, Model model, const DampingWeights& damping)
{
	OverlapResult result;
	if (!isRigid(X_AB))
	{
		result.status = QueryStatus::InvalidPose;
		return result;
	}
	const BallTree& treeA = treeOf(A, model);
	const BallTree& treeB = treeOf(B, model);
	if (treeA.empty() || treeB.empty())
	{
		result.status = QueryStatus::EmptyTree;
		return result;
	}
	const Pose X{X_AB.rotation, X_AB.rotation * B.origin + (X_AB.translation - A.origin)};
	if (model != Model::Inner) result.total.dampingWeights = damping;
	const bool normalsChange = !treeA.gradients.empty() || !treeB.gradients.empty();
	for (size_t j = 0; j < treeB.slotCount(); ++j)
	{
		const Piece b = pieceOf(treeB, j, model);
		const Vec3 centerB = X * b.ball.center();
		const SymmetricMatrix3 shapeB = rotated(X.rotation, b.ball.shape());
		for (size_t i = 0; i < treeA.slotCount(); ++i)
		{
			const Piece a = pieceOf(treeA, i, model);
			const bool met = model == Model::Inner ? addBalls(result.total, a, b, centerB, X.rotation)
												   : addEllipsoids(result.total, a, b, centerB, shapeB, X.rotation, normalsChange);
			if (!met) continue;
			++result.ballTests;
		}
	}
	if (model != Model::Inner) result.total.line = {};
	return result;
}
}  // namespace ist
