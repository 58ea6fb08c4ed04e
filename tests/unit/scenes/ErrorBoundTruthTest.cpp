// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Accuracy/ErrorShare.h"
#include "BulletISTCollision/Core/Accuracy/ForceErrorBound.h"
#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"
#include "TestSupport/SceneFiles/SceneShapes.h"
#include "demos/scenes/Truth/PoseSampler.h"

#include <gtest/gtest.h>

#include <random>

using namespace ist;
using namespace scenes;

namespace
{
struct Body
{
	Mesh mesh;
	InnerSphereTree tree;
};

Body makeBody(Mesh mesh)
{
	BuildOptions options;
	options.maxSpheres = 1500;
	Body body{std::move(mesh), {}};
	body.tree = buildTree(body.mesh, options).value();
	EXPECT_FALSE(body.tree.calibration.empty()) << "builders measure it";
	addLevels(body.tree);
	return body;
}

constexpr double kErrors[] = {0.1, 0.3};

struct Outcome
{
	int poses = 0, held = 0, kept = 0;
	int64_t pairs = 0, leaves = 0;
};

/// Adds to one outcome for each of `kErrors`.
void judge(const Body& A, const Body& B, Outcome* outcomes)
{
	QueryWorkspace workspace;
	const OverlapQuadrature quadrature(A.mesh, B.mesh);
	for (const double overlap : {0.001, 0.02, 0.2})
		for (const Pose& X : posesAtOverlap(quadrature, overlap, 5, 77))
		{
			const Vec3 truth = quadrature.integrate(X, {}, 50, 6000).wrench().force;
			for (size_t i = 0; i < std::size(kErrors); ++i)
			{
				ForceTolerance accepted;
				accepted.error = kErrors[i];
				const BoundedOverlap answer = queryWithTolerance(A.tree, B.tree, X, workspace, accepted);
				const double off = norm(pressureWrench(answer.overlap.total, {}).force - truth);
				++outcomes[i].poses;
				outcomes[i].kept += answer.kept;
				outcomes[i].held += off <= std::max(kErrors[i], answer.errorBound) * std::max(norm(truth), forceFloor(A.tree, B.tree));
				outcomes[i].pairs += answer.overlap.total.pairs;
				outcomes[i].leaves += queryOverlap(A.tree, B.tree, X, workspace).total.pairs;
			}
		}
}
}  // namespace

// None of these pairs was looked at when the factors of the error bound were chosen.
TEST(ForceErrorBound, HoldsAgainstQuadratureForRoundAndThinBodies)
{
	const Body cone = makeBody(makeConeMesh(0.4, 0.8, 32)), slab = makeBody(makeBoxMesh({0.5, 0.3, 0.02})),
			   ball = makeBody(makeSphereMesh(0.4, 3)), stick = makeBody(makeCylinderMesh(0.03, 0.5, 24));
	Outcome outcomes[std::size(kErrors)];
	judge(cone, ball, outcomes);
	judge(slab, cone, outcomes);
	judge(stick, ball, outcomes);
	judge(stick, slab, outcomes);
	// Two poses are the standard error of such a count.
	for (const Outcome& outcome : outcomes) EXPECT_GE(outcome.held, 0.95 * outcome.poses - 2);
	const Outcome& loose = outcomes[1];
	EXPECT_GT(loose.kept, 0.2 * loose.poses);
	EXPECT_LT(double(loose.pairs), 0.7 * double(loose.leaves));
	std::printf("held %d and %d, kept %d and %d of %d poses; pairs %.2f of the leaves'\n", outcomes[0].held, loose.held, outcomes[0].kept,
		loose.kept, loose.poses, double(loose.pairs) / double(loose.leaves));
}

namespace
{
/// Pairs of the coarsest level whose own answer keeps the error; of the leaves where none does.
int64_t pairsOfTheLevelThatDoes(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X, double error, QueryWorkspace& workspace)
{
	QueryOptions options;
	for (options.level = levelCount(A, B);; --options.level)
	{
		const OverlapIntegrals answer = queryOverlap(A, B, X, workspace, options).total;
		const ContactSeen seen = seenIn(answer);
		const bool keeps = shareOfTrueForce(forceErrorBound(A, B, options.level, seen), seen.force, forceFloor(A, B)) <= error;
		if (keeps || options.level == 0) return answer.pairs;
	}
}

/// Turned at random, sharing 5 to 25 % of the smaller body.
std::vector<Pose> deepPoses(const InnerSphereTree& A, const InnerSphereTree& B, size_t count)
{
	std::mt19937 random(31);
	std::normal_distribution<double> gauss;
	std::uniform_real_distribution<double> apart(0, 3);
	QueryWorkspace workspace;
	std::vector<Pose> poses;
	while (poses.size() < count)
	{
		const Mat3 R = rotationMatrix(quaternionFromRotationVector({gauss(random), gauss(random), gauss(random)}));
		const Vec3 direction = normalized({gauss(random), gauss(random), gauss(random)});
		const Pose X{R, A.origin - R * B.origin + apart(random) * direction};
		const double overlap = queryOverlap(A, B, X, workspace).total.volume / std::min(A.volume, B.volume);
		if (overlap > 0.05 && overlap < 0.25) poses.push_back(X);
	}
	return poses;
}
}  // namespace

// A knot through a ring is pressed from all sides: of what is left, a coarse level sees too little to trust itself.
TEST(ForceErrorBound, WhereForcesCancelALevelBetweenIsAskedBeforeTheLeaves)
{
	InnerSphereTree knot = makeBody(makeTorusKnotMesh(2, 1, 0.45)).tree, torus = makeBody(makeTorusMesh(0.5, 0.2)).tree;
	knot.surface = torus.surface = {};  // pairs of leaves are counted
	QueryWorkspace workspace;
	ForceTolerance accepted;
	accepted.error = 0.4;
	int64_t asked = 0, needed = 0, leaves = 0;
	for (const Pose& X : deepPoses(knot, torus, 40))
	{
		asked += queryWithTolerance(knot, torus, X, workspace, accepted).pairs;
		needed += pairsOfTheLevelThatDoes(knot, torus, X, accepted.error, workspace);
		leaves += queryOverlap(knot, torus, X, workspace).total.pairs;
	}
	ASSERT_LT(double(needed), 0.6 * double(leaves)) << "a level between does";
	// Three looks, each of half the next one's pairs, are 1.75; by their own word coarse levels send to the leaves, which makes 2.1.
	EXPECT_LT(double(asked), 1.75 * double(needed));
}
