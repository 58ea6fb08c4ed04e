// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/LeafClearance.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "tests/unit/Core/Query/ConvexSolid.h"
#include "tests/unit/Core/Query/SurfaceBodies.h"
#include "tests/unit/CountingAllocator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

using namespace ist;

namespace
{
constexpr double kPi = std::numbers::pi;
const Vec3 kHalf{0.05, 0.04, 0.03}, kPlace{1, -2, 3};  // a brick, whose mesh frame has its origin elsewhere

InnerSphereTree treeOfMesh(const Mesh& mesh, int spheres = 300)
{
	BuildOptions options;
	options.maxSpheres = spheres;
	return buildTree(mesh, options).value();
}

const InnerSphereTree& brick()
{
	static const InnerSphereTree tree = treeOfMesh(translated(makeBoxMesh(kHalf), kPlace));
	return tree;
}

/// A ball of 82,000 triangles, whose surface has more elements than the builder of trees would give it.
const InnerSphereTree& ball()
{
	static const InnerSphereTree tree = [] {
		const Mesh mesh = makeSphereMesh(0.1, 6);
		InnerSphereTree body = treeOfMesh(makeSphereMesh(0.1, 4));
		BodySurfaceOptions options;
		options.elements = 12000;
		options.cells = 500;
		body.surface = buildBodySurface(MeshDistance(mesh), options).value();
		return body;
	}();
	return tree;
}

Mat3 randomTurn(std::mt19937& random) { return randomPose(random, 0).rotation; }

Vec3 randomDirection(std::mt19937& random)
{
	std::normal_distribution<double> u;
	const double x = u(random), y = u(random);
	return normalized({x, y, u(random)});
}

/// The half-space { x : normal . x <= offset } of A's mesh frame, in a field's frame with the pose `X`.
HalfSpaceField planeIn(const Pose& X, const Vec3& normal, double offset)
{
	return {normalized(transpose(X.rotation) * normal), offset - dot(normal, X.translation)};
}

/// What a convex A shares with a field of flat sides: the parts in which each side is the nearest, by exact clipping.
struct ExactOverlap
{
	double volume = 0;
	Wrench normalB;  // about the origin of A's tree, in A's axes

	ExactOverlap(const ConvexSolid& A, const AnalyticField& field, const Pose& X_AF, const Vec3& about)
	{
		const int count = field.sideCount();
		for (int i = 0; i < count; ++i)
		{
			// The depth below side i is a_i - n_i . x.
			const auto planeOf = [&](int side) {
				const FieldSide s = field.side(side, {}, {});
				const Vec3 n = X_AF.rotation * s.normal;
				return std::pair{n, s.depth + dot(n, X_AF.translation)};
			};
			const auto [n, a] = planeOf(i);
			ConvexSolid part = A.below(n, a);
			for (int j = 0; j < count; ++j)
				if (const auto [m, b] = planeOf(j); j != i) part = part.below(m - n, b - a);
			const double v = part.volume();
			if (!(v > 0)) continue;
			volume += v;
			normalB.force += v * n;
			normalB.torque += v * cross(part.centroid() - about, n);
		}
	}
};

void expectExact(const OverlapIntegrals& found, const ExactOverlap& exact, double tolerance, const char* what)
{
	const double size = exact.volume, arm = 0.05;
	EXPECT_NEAR(found.volume, size, tolerance * size) << what;
	EXPECT_LT(norm(found.normalB.force - exact.normalB.force), tolerance * size) << what;
	EXPECT_LT(norm(found.normalB.torque - exact.normalB.torque), tolerance * size * arm) << what;
}

ConvexSolid solidBrick() { return ConvexSolid::box(kHalf).placed({{}, kPlace}); }
}  // namespace

TEST(SurfaceInField, FlatFaceOnAHalfSpaceIsExact)
{
	QueryWorkspace workspace;
	std::mt19937 random(1);
	for (const double far : {0.0, 1000.0})
		for (const double depth : {1e-5, 1e-4, 1e-3, 1e-2})
			for (int i = 0; i < 10; ++i)
			{
				const Pose X{randomTurn(random), randomPose(random, far).translation};
				const OverlapResult found = queryField(brick(), planeIn(X, {0, 0, 1}, kPlace.z - kHalf.z + depth), X, workspace);
				const double volume = 4 * kHalf.x * kHalf.y * depth, rounding = 1e-5 + 1e-8 / depth;
				EXPECT_NEAR(found.total.volume, volume, rounding * volume) << depth;
				EXPECT_NEAR(found.total.normalB.force.z, volume, rounding * volume) << depth;
				EXPECT_NEAR(found.total.areaVector.z, 4 * kHalf.x * kHalf.y, 1e-4 * kHalf.x * kHalf.y);
				EXPECT_NEAR(found.total.stiffnessB(2, 2), 4 * kHalf.x * kHalf.y, 1e-4 * kHalf.x * kHalf.y);
				EXPECT_NEAR(found.total.depthB, 0.5 * volume * depth, 0.02 * volume * depth) << depth;
				EXPECT_LT(
					norm(found.total.normalB.torque - cross({0, 0, 0.5 * depth - kHalf.z}, found.total.normalB.force)), 1e-5 * volume);
			}
}

/// Contact of a corner covers next to nothing of the elements around it, which are as large as the faces of the bodies.
TEST(SurfaceInField, ACornerThatHardlyReachesInHasItsVolume)
{
	static const InnerSphereTree slab = treeOfMesh(makeBoxMesh({0.5, 0.05, 0.5}));
	QueryWorkspace workspace;
	std::mt19937 random(6);
	std::uniform_real_distribution<double> place(-0.3, 0.3);
	for (int i = 0; i < 100; ++i)
		for (const double depth : {5e-6, 2e-5, 1e-4, 5e-4})
		{
			const Mat3 R = randomTurn(random);
			const Vec3 up = transpose(R) * Vec3{0, 1, 0};
			const Vec3 corner = kPlace - Vec3{std::copysign(kHalf.x, up.x), std::copysign(kHalf.y, up.y), std::copysign(kHalf.z, up.z)};
			const double slopes = std::fabs(up.x * up.y * up.z), least = std::min({std::fabs(up.x), std::fabs(up.y), std::fabs(up.z)});
			if (depth > 0.05 * least) continue;  // the edges at the corner must end above the plane
			const double volume = depth * depth * depth / (6 * slopes), area = 0.5 * depth * depth / slopes;

			const OverlapResult onPlane = queryField(brick(), HalfSpaceField(up, dot(up, corner) + depth), {}, workspace);
			EXPECT_NEAR(onPlane.total.volume, volume, 0.02 * volume) << depth;
			EXPECT_LT(norm(onPlane.total.normalB.force - volume * up), 0.02 * volume) << depth;
			EXPECT_LT(norm(onPlane.total.areaVector - area * up), 0.02 * area) << depth;

			// Places are single precision and lie within a metre: the depth is off by up to one unit in their last place, 6e-8 m.
			const double depthError = 0x1p-24 / depth;
			const Pose X_WA{R, Vec3{place(random), 0.05 - depth, place(random)} - R * corner};
			const OverlapResult onSlab = queryOverlap(brick(), slab, inverse(X_WA), workspace);
			EXPECT_NEAR(onSlab.total.volume, volume, (0.01 + 3 * depthError) * volume) << depth;
			EXPECT_LT(norm(onSlab.total.areaVector - area * up), (0.01 + 2 * depthError) * area) << depth;
		}
}

TEST(SurfaceInField, BrickInAHalfSpaceAgreesWithExactClipping)
{
	QueryWorkspace workspace;
	std::mt19937 random(2);
	std::uniform_real_distribution<double> u(-1, 1);
	for (int i = 0; i < 200; ++i)
	{
		const double far = i % 2 ? 1000 : 1;
		const Pose X{randomTurn(random), randomPose(random, far).translation};
		const Vec3 n = randomDirection(random);
		const double reach = std::fabs(n.x) * kHalf.x + std::fabs(n.y) * kHalf.y + std::fabs(n.z) * kHalf.z;
		const HalfSpaceField plane = planeIn(X, n, dot(n, kPlace) + 0.98 * reach * u(random));
		const ExactOverlap exact(solidBrick(), plane, X, brick().origin);
		// A sliver of less than a hundred-thousandth of a face counts as nothing.
		expectExact(queryField(brick(), plane, X, workspace).total, exact, 1e-3, "half-space");
	}
}

TEST(SurfaceInField, BodyDeepInAHalfSpaceIsPushedOutByItsWholeVolume)
{
	QueryWorkspace workspace;
	std::mt19937 random(3);
	const double volume = 8 * kHalf.x * kHalf.y * kHalf.z;
	for (const double depth : {0.08, 1.0, 100.0})
	{
		const Vec3 n = randomDirection(random);
		const OverlapResult found = queryHalfSpace(brick(), n, dot(n, kPlace) + depth, workspace);
		EXPECT_NEAR(found.total.volume, volume, (1e-5 + 1e-5 * depth) * volume);
		EXPECT_LT(norm(found.total.normalB.force - volume * n), (1e-5 + 1e-5 * depth) * volume);
		EXPECT_EQ(found.patchCount, 1);
		EXPECT_NEAR(found.total.depthB, volume * depth, 0.01 * volume * depth);
		QueryOptions leaves;
		leaves.model = Model::Leaf;
		EXPECT_NEAR(queryHalfSpace(brick(), n, dot(n, kPlace) + depth, workspace, leaves).total.volume, volume, 0.01 * volume);
	}
}

TEST(SurfaceInField, BrickInABoxAgreesWithExactClipping)
{
	QueryWorkspace workspace;
	std::mt19937 random(4);
	int checked = 0;
	for (const Vec3& half : {Vec3{0.06, 0.05, 0.02}, Vec3{0.02, 0.5, 0.03}, Vec3{0.01, 0.01, 0.01}, Vec3{0.3, 0.3, 0.3}, Vec3{25, 25, 0.5}})
		for (int i = 0; i < 100; ++i)
		{
			// A point of the box, often near its surface, is a point of the brick.
			Vec3 onBox, onBrick;
			for (int axis = 0; axis < 3; ++axis)
			{
				std::uniform_real_distribution<double> u(-1, 1);
				onBox[axis] = half[axis] * (i % 3 && axis == i % 3 ? 1 : u(random));
				onBrick[axis] = kHalf[axis] * u(random);
			}
			Pose X{randomTurn(random), {}};
			X.translation = kPlace + onBrick - X.rotation * onBox;
			const BoxField box(half);
			const ExactOverlap exact(solidBrick(), box, X, brick().origin);
			if (exact.volume < 1e-10) continue;
			++checked;
			expectExact(queryField(brick(), box, X, workspace).total, exact, 1e-3, "box");
		}
	EXPECT_GT(checked, 400);
}

TEST(SurfaceInField, BallOnAHalfSpaceFollowsTheCapFormula)
{
	QueryWorkspace workspace;
	std::mt19937 random(5);
	const double R = 0.1;
	const struct
	{
		double share, tolerance;
	} rows[] = {{1e-3, 0.15}, {1e-2, 0.02}, {1e-1, 0.003}};
	for (const auto& [share, tolerance] : rows)
	{
		const double depth = 2 * R * share, cap = kPi * depth * depth * (R - depth / 3);
		double force = 0, volume = 0;
		constexpr int kPoses = 40;
		for (int i = 0; i < kPoses; ++i)
		{
			const Pose X{randomTurn(random), randomPose(random, i % 2 ? 1000 : 1).translation};
			const Vec3 n = randomDirection(random);
			const OverlapIntegrals found = queryField(ball(), planeIn(X, n, depth - R), X, workspace).total;
			force += std::pow(norm(found.normalB.force) / cap - 1, 2) / kPoses;
			volume += std::pow(found.volume / cap - 1, 2) / kPoses;
			EXPECT_LT(norm(found.normalB.torque), 0.01 * R * cap);
		}
		EXPECT_LT(std::sqrt(force), tolerance) << share;
		EXPECT_LT(std::sqrt(volume), tolerance) << share;
	}
}

// A body that slides on a plane must not feel it: the elements of a curved surface have gaps, but the plane has one normal.
TEST(SurfaceInField, ForceOfAPlaneOrAFloorIsAlongItsNormalAndItsStiffnessIsThatOfAFoundation)
{
	QueryWorkspace workspace;
	std::mt19937 random(11);
	const InnerSphereTree torus = treeOfMesh(makeTorusMesh(0.1, 0.04, 96, 48));
	for (int i = 0; i < 40; ++i)
	{
		const Vec3 n = randomDirection(random);
		Pose X{randomTurn(random), {}};
		const Vec3 up = X.rotation.column(2);
		X.translation = torus.origin - (0.6 + 0.003 * i) * up;
		const OverlapIntegrals floor = queryField(torus, BoxField({20, 20, 0.5}), X, workspace).total;
		const OverlapIntegrals plane = queryHalfSpace(torus, n, dot(n, torus.origin) + 0.001 * i, workspace).total;
		const auto expectAlong = [&](const OverlapIntegrals& sums, const Vec3& normal) {
			EXPECT_LT(norm(sums.normalB.force - sums.volume * normal), 1e-6 * sums.volume);
			EXPECT_NEAR(sums.slidingVolumeB, sums.volume, 1e-12 * sums.volume);
			const Vec3 across = normalized(cross(normal, {0.3, 0.5, 0.7}));
			const Wrench slid = sums.stiffnessB * Twist{across, {}};
			EXPECT_LT(norm(slid.force) + norm(slid.torque) / 0.1, 1e-6 * norm(sums.areaVector));
		};
		if (floor.volume > 0) expectAlong(floor, up);
		ASSERT_GT(plane.volume, 0);
		expectAlong(plane, n);
	}
}

TEST(SurfaceInField, BoxInClosedFormAgreesWithItsTree)
{
	QueryWorkspace workspace;
	std::mt19937 random(6);
	const Vec3 half{0.2, 0.15, 0.1};
	const InnerSphereTree tree = treeOfMesh(makeBoxMesh(half));
	for (const double depth : {1e-4, 1e-3, 5e-3, 0.02})
		for (int i = 0; i < 10; ++i)
		{
			const Mat3 turn = turned(0.3 * i, {0, 0, 1});
			const Pose X{turn, kPlace + Vec3{0, 0, depth - kHalf.z - half.z} - turn * Vec3{0.01 * i, 0.005 * i, 0}};
			const OverlapIntegrals closed = queryField(brick(), BoxField(half), X, workspace).total;
			const OverlapIntegrals meshes = queryOverlap(brick(), tree, X, workspace).total;
			EXPECT_NEAR(closed.volume, meshes.volume, 0.01 * meshes.volume) << depth;
			EXPECT_LT(norm(closed.normalB.force - meshes.normalB.force), 0.01 * meshes.volume) << depth;
			EXPECT_LT(norm(closed.normalA.force - meshes.normalA.force), 0.01 * meshes.volume) << depth;
			EXPECT_LT(norm(closed.normalB.torque - meshes.normalB.torque), 0.01 * 0.05 * meshes.volume) << depth;
			EXPECT_NEAR(closed.depthB, meshes.depthB, 0.03 * meshes.depthB) << depth;
			for (int k = 0; k < 3; ++k)
				EXPECT_NEAR(closed.stiffnessB(k, k), meshes.stiffnessB(k, k), 0.01 * meshes.stiffnessB(2, 2)) << depth;
		}
}

TEST(SurfaceInField, ContactBeginsWhereTheMeshTouches)
{
	QueryWorkspace workspace;
	std::mt19937 random(7);
	const Vec3 wide{0.4, 0.3, 0.1};
	for (int i = 0; i < 30; ++i)
	{
		const Vec3 n = randomDirection(random);
		const double low = dot(n, kPlace) - std::fabs(n.x) * kHalf.x - std::fabs(n.y) * kHalf.y - std::fabs(n.z) * kHalf.z;
		EXPECT_EQ(queryHalfSpace(brick(), n, low - 1e-6, workspace).total.pairs, 0);
		EXPECT_GT(queryHalfSpace(brick(), n, low + 1e-4, workspace).total.volume, 0);
		const double lowest = -0.1 - 4 * ball().surface.surface.largestError();
		EXPECT_EQ(queryHalfSpace(ball(), n, lowest - 1e-6, workspace).total.pairs, 0);

		const Mat3 turn = turned(0.2 * i, {0, 0, 1});
		const auto onTop = [&](double depth) { return Pose{turn, kPlace + Vec3{0.01 * i, 0, depth - kHalf.z - wide.z}}; };
		EXPECT_EQ(queryField(brick(), BoxField(wide), onTop(-1e-6), workspace).total.pairs, 0);
		EXPECT_GT(queryField(brick(), BoxField(wide), onTop(1e-6), workspace).total.volume, 0);
	}
}

TEST(SurfaceInField, FloorOfFiftyMetresIsAsExactAsASmallOne)
{
	QueryWorkspace workspace;
	std::mt19937 random(8);
	std::uniform_real_distribution<double> u(-1, 1);
	const Vec3 half{25, 25, 0.5};
	const double depth = 1e-4, volume = 4 * kHalf.x * kHalf.y * depth;
	for (int i = 0; i < 100; ++i)
	{
		const Mat3 turn = turned(kPi * u(random), {0, 0, 1});
		const Pose X{turn, kPlace + Vec3{0, 0, depth - kHalf.z - half.z} - turn * Vec3{24.9 * u(random), 24.9 * u(random), 0}};
		const OverlapIntegrals found = queryField(brick(), BoxField(half), X, workspace).total;
		EXPECT_NEAR(found.normalB.force.z, volume, 1e-3 * volume);
		EXPECT_NEAR(found.volume, volume, 1e-3 * volume);
	}
}

TEST(SurfaceInField, ClearanceIsNeverMoreThanTheDistanceAndIsExactForFlatFaces)
{
	QueryWorkspace workspace;
	std::mt19937 random(9);
	const InnerSphereTree torus = treeOfMesh(makeTorusMesh(0.1, 0.04, 96, 48));
	const BoxField box({0.2, 0.1, 0.15});
	int advanced = 0;
	for (int i = 0; i < 100; ++i)
	{
		const InnerSphereTree& A = i % 2 ? brick() : torus;
		const Vec3 way = randomDirection(random);
		Pose X{randomTurn(random), {}};
		X.translation = A.origin + 0.6 * way;
		for (int k = 0; k < 40; ++k)
		{
			const double clearance = leafClearance(A, box, X, kMostOpenedForClearance);
			if (!(clearance > 1e-5)) break;
			X.translation -= 0.999 * clearance * way;
			++advanced;
			ASSERT_EQ(queryField(A, box, X, workspace).total.pairs, 0) << i << " " << k;
		}
	}
	EXPECT_GT(advanced, 500);
	const HalfSpaceField below({0, 0, 1}, kPlace.z - kHalf.z - 1e-3);
	EXPECT_NEAR(leafClearance(brick(), below, {}, kMostOpenedForClearance), 1e-3, 1e-4);
}

TEST(SurfaceInField, LeavesAnswerWhereTheyAreAskedForAndForCurvedForms)
{
	QueryWorkspace workspace;
	const Pose X{{}, kPlace - Vec3{0, 0, 0.12}};
	const BoxField box({0.1, 0.1, 0.1});
	const auto ofSurfaces = [&](const AnalyticField& field, const QueryOptions& options) {
		const OverlapResult found = queryField(brick(), field, X, workspace, options);
		EXPECT_GT(found.total.volume, 0);
		return found.total.surfaceVolume;
	};
	QueryOptions leaves, listed, inner, plain;
	leaves.model = Model::Leaf;
	listed.sortPairs = true;
	inner.requireInnerOverlap = true;
	EXPECT_GT(ofSurfaces(box, plain), 0);
	EXPECT_GT(ofSurfaces(box, inner), 0);
	EXPECT_EQ(ofSurfaces(box, leaves), 0);
	EXPECT_EQ(ofSurfaces(box, listed), 0);
	EXPECT_EQ(ofSurfaces(SphereField(0.1), plain), 0);
}

TEST(SurfaceInField, RepeatsItselfAndAllocatesNothing)
{
	QueryWorkspace first, second;
	std::mt19937 random(10);
	queryHalfSpace(brick(), {0, 0, 1}, kPlace.z, first);
	queryHalfSpace(brick(), {0, 0, 1}, kPlace.z, second);
	queryHalfSpace(ball(), {0, 0, 1}, 0, first);
	const long before = allocationCount();
	for (int i = 0; i < 30; ++i)
	{
		Pose X{randomTurn(random), {}};
		X.translation = kPlace + 0.08 * randomDirection(random);
		const BoxField box({0.05, 0.06, 0.07});
		const OverlapIntegrals a = queryField(brick(), box, X, first).total;
		queryHalfSpace(ball(), {0, 0, 1}, 0.001 * i, first);
		const OverlapIntegrals b = queryField(brick(), box, X, second).total;
		EXPECT_EQ(a.volume, b.volume);
		EXPECT_EQ(norm(a.normalB.torque - b.normalB.torque), 0);
	}
	EXPECT_EQ(allocationCount(), before);
}
