// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Law/btContactLaw.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <random>

using ist::Vec3;

namespace
{
constexpr double kStiffness = 1e5;

std::shared_ptr<const ist::InnerSphereTree> build(const ist::Mesh& mesh, int64_t spheres)
{
	ist::BuildOptions options;
	options.maxSpheres = spheres;
	ist::Result<ist::InnerSphereTree> built = ist::buildTree(mesh, options);
	EXPECT_TRUE(built);
	return built ? std::make_shared<const ist::InnerSphereTree>(std::move(built).value()) : nullptr;
}

const std::shared_ptr<const ist::InnerSphereTree>& cube()
{
	static const auto tree = build(ist::makeBoxMesh({0.5, 0.5, 0.5}), 1000);
	return tree;
}

ist::Pose randomPose(std::mt19937_64& random, double reach)
{
	std::uniform_real_distribution<double> u(-1, 1);
	const double a = u(random), b = u(random), c = u(random);
	const Vec3 spin{2 * a, 2 * b, 2 * c};
	const double x = u(random), y = u(random);
	return {ist::rotationMatrix(ist::quaternionFromRotationVector(spin)), Vec3{x, y, u(random)} * reach};
}

void fill(btISTContact& contact, const ist::OverlapResult& found)
{
	contact.total = found.total;
	contact.patchCount = 1;
	contact.patches[0] = found.total;
	contact.constants.k = kStiffness;
}

/// Contact of A with the half-space { n . x <= offset } of its mesh frame.
btISTContact onHalfSpace(const std::shared_ptr<const ist::InnerSphereTree>& tree, const Vec3& n, double offset, const ist::Pose& X_WA)
{
	ist::QueryWorkspace workspace;
	btISTContact contact;
	contact.treeA = tree;
	contact.halfSpace = true;
	contact.X_WA = X_WA;
	ist::QueryOptions options;
	options.damping = {0, 1};
	fill(contact, ist::queryHalfSpace(*tree, n, offset, workspace, options));
	contact.constants.weightA = 0;
	contact.constants.weightB = 1;
	return contact;
}

ist::InnerSphereTree withoutSurface(ist::InnerSphereTree tree)
{
	tree.surface = {};
	return tree;
}

btISTContact onEachOther(const ist::Pose& X_WA, const ist::Pose& X_WB, const std::shared_ptr<const ist::InnerSphereTree>& tree = cube())
{
	ist::QueryWorkspace workspace;
	btISTContact contact;
	contact.treeA = contact.treeB = tree;
	contact.X_WA = X_WA;
	ist::QueryOptions options;
	options.damping = {0.3, 0.7};
	fill(contact, ist::queryOverlap(*tree, *tree, ist::inverse(X_WA) * X_WB, workspace, options));
	contact.constants.weightA = 0.3;
	contact.constants.weightB = 0.7;
	return contact;
}

double quadratic(const ist::SymmetricMatrix6& m, const Vec3& linear, const Vec3& angular)
{
	const double v[6] = {linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
	double sum = 0;
	for (int i = 0; i < 6; ++i)
		for (int j = 0; j < 6; ++j) sum += v[i] * m(i, j) * v[j];
	return sum;
}

ist::Pose moved(const ist::Pose& X, const Vec3& about, const Vec3& shift, const Vec3& spin)
{
	const ist::Mat3 R = ist::rotationMatrix(ist::quaternionFromRotationVector(spin));
	return {R * X.rotation, about + shift + R * (X.translation - about)};
}
}  // namespace

// The oracle is the wrench of the whole query about A's centre of mass, transformed by hand to the patch's point.
TEST(ContactLaw, WrenchIsTheModelsOwnAboutTheCentroid)
{
	std::mt19937_64 random(1);
	for (int i = 0; i < 10; ++i)
	{
		const ist::Pose X_WA = randomPose(random, i % 3 ? 2 : 1000);
		const btISTContact contact = onEachOther(X_WA, X_WA * ist::Pose{randomPose(random, 1).rotation, {0.3, 0.85, -0.2}});
		btContactPatch patch;
		ASSERT_TRUE(evaluateContactPatch(contact, 0, patch));
		const ist::Wrench own = kStiffness * (0.7 * contact.total.normalB - 0.3 * contact.total.normalA);
		const Vec3 origin = X_WA * contact.treeA->origin;
		const Vec3 force = X_WA.rotation * own.force;
		EXPECT_LT(norm(patch.wrench.force - force), 1e-12 * norm(force));
		EXPECT_LT(norm(patch.wrench.torque + cross(patch.point - origin, force) - X_WA.rotation * own.torque), 1e-9 * norm(force));
		EXPECT_LT(norm(patch.normal - force / norm(force)), 1e-12);
		EXPECT_LT(distance(patch.point, origin + X_WA.rotation * (contact.total.firstMoment / contact.total.volume)), 1e-9);
	}
}

// A flat face on a half-space follows the closed form of an elastic foundation: k A along the normal, k I about the axes in the face, and
// zero otherwise. The face is 1 m x 1 m. The slope of the force ripples with the layers of leaves below the face. The mean over some
// depths must be within 5 %, each value within 15 %.
TEST(ContactLaw, CubeOnAHalfSpaceIsAnElasticFoundation)
{
	std::mt19937_64 random(2);
	constexpr int kDepths = 12;
	double normal = 0, turning[2] = {};
	for (int i = 0; i < kDepths; ++i)
	{
		const double depth = (5 + 0.5 * i) * cube()->meanGap;
		const ist::Pose X_WA = randomPose(random, 5);
		btContactPatch patch;
		ASSERT_TRUE(evaluateContactPatch(onHalfSpace(cube(), {0, 1, 0}, depth - 0.5, X_WA), 0, patch));
		const Vec3 n = X_WA.rotation * Vec3{0, 1, 0}, t = X_WA.rotation * Vec3{1, 0, 0}, b = X_WA.rotation * Vec3{0, 0, 1};
		EXPECT_GT(dot(patch.normal, n), 1 - 1e-12);
		EXPECT_NEAR(norm(patch.wrench.force), kStiffness * depth, 0.03 * kStiffness * depth);
		const double along = quadratic(patch.stiffness, n, {}) / kStiffness;
		const double about[2] = {12 * quadratic(patch.stiffness, {}, t) / kStiffness, 12 * quadratic(patch.stiffness, {}, b) / kStiffness};
		for (double share : {along, about[0], about[1]}) EXPECT_NEAR(share, 1, 0.15) << depth;
		normal += along / kDepths;
		for (int axis = 0; axis < 2; ++axis) turning[axis] += about[axis] / kDepths;
		EXPECT_LT(quadratic(patch.stiffness, t, {}), 1e-6 * kStiffness);
		EXPECT_LT(quadratic(patch.stiffness, {}, n), 1e-6 * kStiffness);
	}
	for (double share : {normal, turning[0], turning[1]}) EXPECT_NEAR(share, 1, 0.05);
}

// Where the stiffness is positive definite, it is the derivative of the model's own wrench: along and about the axes of a flat face.
TEST(ContactLaw, StiffnessIsTheSlopeOfTheModelsOwnWrench)
{
	std::mt19937_64 random(3);
	const double depth = 8 * cube()->meanGap, step = 1e-4;
	for (int i = 0; i < 4; ++i)
	{
		const ist::Pose X_WA = randomPose(random, 5);
		const Vec3 n = X_WA.rotation * Vec3{0, 1, 0}, t = X_WA.rotation * Vec3{1, 0, 0};
		const Vec3 onPlane = X_WA * Vec3{0, depth - 0.5, 0};
		const auto wrenchAt = [&](const ist::Pose& X, const Vec3& about) {
			const ist::Pose back = ist::inverse(X);
			const Vec3 normal = back.rotation * n;
			btContactPatch p;
			EXPECT_TRUE(evaluateContactPatch(onHalfSpace(cube(), normal, dot(normal, back * onPlane), X), 0, p));
			return ist::Wrench{p.wrench.force, p.wrench.torque + cross(p.point - about, p.wrench.force)};
		};
		btContactPatch patch;
		ASSERT_TRUE(evaluateContactPatch(onHalfSpace(cube(), {0, 1, 0}, depth - 0.5, X_WA), 0, patch));
		const Vec3 c = patch.point;
		const ist::Wrench down = wrenchAt(moved(X_WA, c, -step * n, {}), c), up = wrenchAt(moved(X_WA, c, step * n, {}), c);
		const double linear = dot(down.force - up.force, n) / (2 * step);
		EXPECT_NEAR(quadratic(patch.stiffness, n, {}), linear, 0.02 * linear);
		const ist::Wrench left = wrenchAt(moved(X_WA, c, {}, -step * t), c), right = wrenchAt(moved(X_WA, c, {}, step * t), c);
		const double angular = dot(left.torque - right.torque, t) / (2 * step);
		// The geometric term, which the stiffness leaves out, is the force times the depth of the centroid.
		const double geometric = norm(patch.wrench.force) * depth;
		EXPECT_NEAR(quadratic(patch.stiffness, {}, t), angular, 0.02 * angular + geometric);
	}
}

// With leaves. The oracle is the sum over the pairs of a query, each along its own normal w, for random twists: d k sum dd L (w . (v + spin
// x r))^2.
TEST(ContactLaw, DampingIsTheIntegralOfThePressureTimesTheSquaredApproach)
{
	const ist::InnerSphereTree leaves = withoutSurface(*cube());
	std::mt19937_64 random(4);
	ist::QueryWorkspace workspace;
	ist::QueryOptions options;
	options.sortPairs = true;
	std::uniform_real_distribution<double> u(-1, 1);
	for (int i = 0; i < 6; ++i)
	{
		const ist::Pose X_WA = randomPose(random, i % 3 ? 3 : 1000), X_AB{randomPose(random, 1).rotation, {0.2, 0.9, -0.1}};
		btISTContact contact = onEachOther(X_WA, X_WA * X_AB, std::make_shared<const ist::InnerSphereTree>(leaves));
		contact.constants.dissipation = 7;
		btContactPatch patch;
		ASSERT_TRUE(evaluateContactPatch(contact, 0, patch));
		const ist::OverlapResult found = ist::queryOverlap(leaves, leaves, X_AB, workspace, options);
		for (int twist = 0; twist < 5; ++twist)
		{
			const Vec3 linear{u(random), u(random), u(random)}, angular{u(random), u(random), u(random)};
			double sum = 0;
			for (int p = 0; p < found.pairCount; ++p)
			{
				const ist::OverlapPair& pair = found.pairs[p];
				const ist::MomentEllipsoid a = cube()->law.ball(pair.ballA), b = cube()->law.ball(pair.ballB);
				const Vec3 arm = X_WA * (contact.treeA->origin + pair.centroid) - patch.point;
				const Vec3 w = X_WA.rotation * (0.7 * (X_AB.rotation * b.normal()) - 0.3 * a.normal());
				const double approach = dot(w, linear + cross(angular, arm));
				sum += double(a.density) * double(b.density) * double(pair.lens) * approach * approach;
			}
			const double expected = 7 * kStiffness * sum;
			EXPECT_NEAR(quadratic(patch.damping, linear, angular), expected, 1e-4 * expected);
		}
	}
}

// When all pairs press in one direction, the damping is that of the whole force.
TEST(ContactLaw, FlatContactIsDampedByTheDissipationTimesTheForce)
{
	std::mt19937_64 random(5);
	const double depth = 6 * cube()->meanGap;
	for (int i = 0; i < 4; ++i)
	{
		const ist::Pose X_WA = randomPose(random, 5);
		btISTContact contact = onHalfSpace(cube(), {0, 1, 0}, depth - 0.5, X_WA);
		contact.constants.dissipation = 3;
		btContactPatch patch;
		ASSERT_TRUE(evaluateContactPatch(contact, 0, patch));
		const Vec3 t = X_WA.rotation * Vec3{1, 0, 0};
		const double whole = 3 * norm(patch.wrench.force);
		EXPECT_NEAR(quadratic(patch.damping, patch.normal, {}), whole, 1e-9 * whole);
		EXPECT_NEAR(quadratic(patch.damping, {}, t), whole / 12, 0.03 * whole / 12);
		EXPECT_LT(quadratic(patch.damping, t, {}), 1e-9 * whole);
		EXPECT_LT(quadratic(patch.damping, {}, patch.normal), 1e-9 * whole);
	}
}

// The forces of a ball's own field pass through its centre, so a ball that spins about it is not braked by any body around it. With one
// normal for the whole patch it would be braked: by a third of the damping of a fall at the speed of its surface.
TEST(ContactLaw, BallThatTurnsInPlaceIsNotDamped)
{
	constexpr double kRadius = 0.5;
	static const auto ball = build(ist::makeSphereMesh(kRadius, 5), 2000);
	std::mt19937_64 random(6);
	for (int i = 0; i < 4; ++i)
	{
		const ist::Pose X_WA = randomPose(random, 5);
		const ist::Pose X_WB = X_WA * ist::Pose{randomPose(random, 1).rotation, ball->origin + Vec3{0, 0.6, 0}};
		ist::QueryWorkspace workspace;
		ist::QueryOptions options;
		btISTContact contact;
		contact.treeA = contact.treeB = ball;
		contact.X_WA = X_WA;
		contact.constants = {kStiffness, 1, 0, 0, 3};
		options.damping = {1, 0};
		options.patches = false;
		contact.patches[0] = contact.total = ist::queryOverlap(*ball, *ball, ist::inverse(X_WA) * X_WB, workspace, options).total;
		contact.patchCount = 1;
		btContactPatch patch;
		ASSERT_TRUE(evaluateContactPatch(contact, 0, patch));
		const Vec3 toPoint = patch.point - X_WA * ball->origin, spin = X_WA.rotation * Vec3{1 / kRadius, 0, 0};
		const double fall = quadratic(patch.damping, patch.normal, {});
		EXPECT_GT(fall, 0.5 * 3 * norm(patch.wrench.force)) << "else there is nothing to compare with";
		// This is the square of the error of the leaves' normals, 2.5 degrees.
		EXPECT_LT(quadratic(patch.damping, cross(spin, toPoint), spin), 0.002 * fall);
	}
}

TEST(ContactLaw, FrictionRadiusIsTheLeverOfADiscAndOfABall)
{
	// The exact values of Int p rho dA / (a Int p dA) are 2/3 under the flat end of a cylinder and 8/15 under a ball.
	const double a = 0.5, depth = 0.1;
	const auto cylinder = build(ist::makeCylinderMesh(a, 0.3, 96), 1000);
	btContactPatch patch;
	ASSERT_TRUE(evaluateContactPatch(onHalfSpace(cylinder, {0, 0, 1}, depth - 0.3, {}), 0, patch));
	EXPECT_NEAR(patch.frictionRadius, 2.0 / 3 * a, 0.03 * a);
	const auto ball = build(ist::makeSphereMesh(a, 5), 500);
	const double dip = 0.15, disc = std::sqrt(dip * (2 * a - dip));
	ASSERT_TRUE(evaluateContactPatch(onHalfSpace(ball, ist::normalized({1, 2, 3}), dip - a, {}), 0, patch));
	EXPECT_NEAR(patch.frictionRadius, 8.0 / 15 * disc, 0.04 * disc);
}

TEST(ContactLaw, StiffnessGrowsByTimeInShortStepsAndAtOnceInLongOnes)
{
	const btPress deep{1000, 1e-4, 1e-3, 1e-6};  // asks for a thousand times more
	const auto growth = [&](double seconds, double h) {
		double k = 1e6;
		for (long i = std::lround(seconds / h); i > 0; --i) k = stiffnessUnder(deep, 0, k, h);
		return k / 1e6;
	};
	for (const double h : {1e-3, 1e-4, 1e-5}) EXPECT_NEAR(growth(0.1, h), std::numbers::e, 1e-9) << h;
	EXPECT_NEAR(growth(1. / 240, 1. / 240), std::exp(std::pow(0.24, -2.5) / 100), 1e-9);
	EXPECT_NEAR(growth(1. / 60, 1. / 60), std::numbers::e, 1e-9);
}

namespace
{
/// Stiffness of a patch of 2 x 2 mm around the origin with the normal z, on a surface with the radius R along x, flat along y.
ist::SymmetricMatrix6 hollow(double R)
{
	constexpr int kPoints = 20;
	ist::SymmetricMatrix6 K;
	for (int i = 0; i < kPoints; ++i)
		for (int j = 0; j < kPoints; ++j)
		{
			const Vec3 r{1e-3 * ((2 * i + 1.0) / kPoints - 1), 1e-3 * ((2 * j + 1.0) / kPoints - 1), 0},
				n = ist::normalized({-r.x / R, 0, 1}), m = cross(r, n);
			const double q[6] = {n.x, n.y, n.z, m.x, m.y, m.z};
			for (int a = 0; a < 6; ++a)
				for (int b = a; b < 6; ++b) K(a, b) += 1e5 / (kPoints * kPoints) * q[a] * q[b];
		}
	return K;
}

double energy(const ist::SymmetricMatrix6& K, const ist::Twist& u)
{
	const ist::Wrench w = K * u;
	return dot(u.linear, w.force) + dot(u.angular, w.torque);
}
}  // namespace

// What slides along x has the stiffness of a pendulum alone, which is left out; so is what rolls. Motions about the axis of the hollow are
// free before and after. All others keep their stiffness, and no motion gains any.
TEST(ContactLaw, WhatSlidesInAHollowIsNotHeldImplicitly)
{
	constexpr double kRadius = 0.2, kStep = 1 / 240.0;
	ist::SymmetricMatrix6 W;  // of a body of 1 kg and 2e-3 kg m^2
	for (int i = 0; i < 6; ++i) W(i, i) = i < 3 ? 1 : 500;
	const ist::SymmetricMatrix6 K = hollow(kRadius);
	btContactPatch patch;
	patch.normal = {0, 0, 1};
	patch.stiffness = K;
	leaveOutSliding(patch, W, 1, kStep);
	const ist::Twist x{{1, 0, 0}, {}}, z{{0, 0, 1}, {}}, aboutX{{}, {1, 0, 0}}, aboutY{{}, {0, 1, 0}},
		aboutAxis{{-kRadius, 0, 0}, {0, 1, 0}};
	ASSERT_GT(energy(K, x), 0.1);
	EXPECT_NEAR(energy(patch.stiffness, x), 0, 1e-9);
	EXPECT_LT(energy(patch.stiffness, aboutY), 0.01 * energy(K, aboutY));
	EXPECT_NEAR(energy(patch.stiffness, aboutAxis), 0, 1e-4 * energy(K, aboutY));
	for (const ist::Twist& u : {z, aboutX}) EXPECT_NEAR(energy(patch.stiffness, u), energy(K, u), 1e-9 * energy(K, u));

	// A hundred times the step: what explicit steps may do is shared among the patches.
	for (const int patches : {1, 4})
	{
		btContactPatch stiff;
		stiff.normal = {0, 0, 1};
		stiff.stiffness = K;
		leaveOutSliding(stiff, W, patches, 100 * kStep);
		const ist::Wrench q = K * x;
		const double lambda = 1e4 * kStep * kStep * energy(W, {q.force, q.torque}) / energy(K, x);
		ASSERT_GT(lambda, 1);
		EXPECT_NEAR(energy(stiff.stiffness, x), (1 - 1 / (patches * lambda)) * energy(K, x), 1e-9 * energy(K, x));
	}

	patch.stiffness = hollow(1e8);
	const ist::SymmetricMatrix6 flat = patch.stiffness;
	leaveOutSliding(patch, W, 1, kStep);
	for (int i = 0; i < 21; ++i) EXPECT_EQ(patch.stiffness.m[i], flat.m[i]);
}

TEST(ContactLaw, ExertsNothingWithoutForce)
{
	btISTContact contact = onHalfSpace(cube(), {0, 1, 0}, -2, {});
	btContactPatch patch;
	EXPECT_FALSE(evaluateContactPatch(contact, 0, patch));
	contact = onHalfSpace(cube(), {0, 1, 0}, -0.4, {});
	contact.constants.k = 0;
	EXPECT_FALSE(evaluateContactPatch(contact, 0, patch));
}
