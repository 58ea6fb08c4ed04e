// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/PairQuery/btISTFirstTouch.h"

#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <LinearMath/btTransformUtil.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <numbers>
#include <random>

using namespace ist;

namespace
{
struct Body
{
	Mesh mesh;
	std::shared_ptr<const InnerSphereTree> tree;

	explicit Body(const Mesh& source) : mesh(source)
	{
		BuildOptions options;
		options.maxSpheres = 200;
		tree = std::make_shared<const InnerSphereTree>(buildTree(mesh, options).value());
	}
	double radiusAbout(const Vec3& center) const
	{
		double radius = 0;
		for (const Vec3& v : mesh.vertices) radius = std::max(radius, distance(v, center));
		return radius;
	}
};

const Body& torus()
{
	static const Body body(makeTorusMesh(0.1, 0.03, 48, 24));
	return body;
}

const Body& brick()
{
	static const Body body(translated(makeBoxMesh({0.12, 0.03, 0.05}), {0.3, -0.1, 0.2}));
	return body;
}

constexpr double kStep = 0.01;

Mat3 turnBy(const Vec3& rotation) { return rotationMatrix(quaternionFromRotationVector(rotation)); }
}  // namespace

// Bullet turns a body by less than its angular velocity asks for where that is more than 45 degrees in a step, and by up to half a turn.
TEST(btISTBodyMotion, EndsWhereBulletTakesTheBody)
{
	std::mt19937 random(2);
	std::uniform_real_distribution<double> u(-1, 1);
	const auto some = [&] { return Vec3{u(random), u(random), u(random)}; };
	const double rounding = 20 * double(std::numeric_limits<btScalar>::epsilon());
	for (int i = 0; i < 200; ++i)
	{
		const btTransform before = toTransform({turnBy(3 * some()), some()});
		const Twist twist{some(), std::exp(7 * std::fabs(u(random))) * some()};
		btTransform after;
		btTransformUtil::integrateTransform(before, toBullet(twist.linear), toBullet(twist.angular), btScalar(kStep), after);
		const Pose start = toPose(before);
		const Pose X = btISTBodyMotion{start.translation, {}}.with(twist, kStep).after(kStep, start), bullet = toPose(after);
		EXPECT_LT(distance(X.translation, bullet.translation), rounding);
		for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}})
			EXPECT_LT(distance(X.rotation * axis, bullet.rotation * axis), rounding) << norm(twist.angular) * kStep << " rad";
	}
}

/// Points of one body, where they are when they come into the ball around the other, have moved relative to it by no more.
TEST(btISTFirstTouch, NoPointTravelsFartherBeforeItTouches)
{
	std::mt19937 random(3);
	std::uniform_real_distribution<double> u(-1, 1);
	const auto some = [&] { return Vec3{u(random), u(random), u(random)}; };
	int touching = 0;
	double largest = 0;
	for (int i = 0; i < 400; ++i)
	{
		const Body &A = i % 2 ? torus() : brick(), &B = i % 4 < 2 ? torus() : brick();
		btISTContact contact;
		contact.treeA = A.tree;
		contact.treeB = B.tree;
		const Vec3 centerA = A.tree->origin + 0.02 * some();
		const Vec3 centerB = B.tree->origin + 0.02 * some();
		const double radiusB = B.radiusAbout(centerB), reach = A.radiusAbout(centerA) + radiusB;
		contact.X_WA = {turnBy(3 * some()), (i % 3 ? 1 : 1000) * some()};
		Pose X_WB{turnBy(3 * some()), {}};
		const Vec3 away = normalized(some());
		X_WB.translation = contact.X_WA * centerA + (0.55 + 0.45 * u(random)) * reach * away - X_WB * centerB;
		contact.X_AB = inverse(contact.X_WA) * X_WB;

		const double speed = std::exp(3 * u(random)), spin = 70 * u(random) * u(random);
		btISTBodyMotion a{contact.X_WA * centerA, {}}, b{X_WB * centerB, {}};
		a = a.with({speed * some(), spin * some()}, kStep);
		b = b.with({speed * some(), spin * some()}, kStep);
		const double bound = btISTFirstTouch::travel(contact, a, b, kStep);
		for (int j = 0; j < 400; ++j)
		{
			const Vec3 now = contact.X_WA * A.mesh.vertices[random() % A.mesh.vertices.size()];
			const double time = 0.5 * kStep * (1 + u(random));
			const Vec3 then = a.after(time, {}) * now;
			if (distance(then, b.center + time * b.twist.linear) > radiusB) continue;
			const double way = distance(inverse(b.after(time, {})) * then, now);
			EXPECT_LE(way, bound * time / kStep + 1e-9) << i;
			largest = std::max(largest, way / (bound * time / kStep));
			++touching;
		}
	}
	EXPECT_GT(touching, 10000);
	EXPECT_GT(largest, 0.9) << "the bound is far too large";
}

TEST(btISTFirstTouch, WheelsThatRollOnEachOtherTravelLittleWhereTheyMeet)
{
	btISTContact contact;
	contact.treeA = contact.treeB = torus().tree;  // of radius 0.13 m, about y
	const double spin = 10, radius = 0.13, apart = 0.25;
	contact.X_AB.translation = {apart, 0, 0};
	const btISTBodyMotion a{{}, {{}, {0, spin, 0}}}, b{contact.X_AB.translation, {{}, {0, -spin, 0}}};
	const double rims = 2 * spin * radius * kStep;
	EXPECT_LT(btISTFirstTouch::travel(contact, a, b, kStep), 0.5 * rims);
	contact.X_AB.translation.x = 0.4;
	const btISTBodyMotion far{contact.X_AB.translation, b.twist};
	EXPECT_EQ(btISTFirstTouch::travel(contact, a, far, kStep), 0);
}

// The edge of a brick crosses the corner of another within a step, and is apart from it at both ends.
TEST(btISTFirstTouch, FindsWhatPassesThroughACornerWithinAStep)
{
	btCollisionObject objectA, objectB;
	btISTContact contact;
	contact.bodyA = &objectA;
	contact.bodyB = &objectB;
	contact.treeA = contact.treeB = brick().tree;
	const double thickness = contact.thickness();
	const btISTShapeField none;
	const btISTQueryRules rules;
	const btISTPairQuery query(none, rules, true, false);
	QueryWorkspace workspace;
	for (const double deep : {0.15, 0.3})
	{
		// B is turned about x by 45 degrees: one of its long edges points down, and passes the upper edge of A's side by `deep`.
		const Vec3 center = brick().tree->origin;
		const double reach = std::sqrt(0.5) * (0.03 + 0.05);
		Pose X{turnBy({0.25 * std::numbers::pi, 0, 0}), {}};
		X.translation = center + Vec3{0, 0.03 + reach - deep * thickness, -0.3} - X.rotation * center;
		contact.X_AB = X;
		const btISTBodyMotion still{center, {}}, fast{X * center, {{0, 0, 0.6 / kStep}, {}}};
		ASSERT_TRUE(btISTFirstTouch(query, still, fast, kStep).moveDeeper(contact, 0.4, workspace)) << deep;
		EXPECT_GT(contact.total.volume, 0);
		EXPECT_GT(contact.ahead, 0.3 * kStep);
		EXPECT_LT(contact.ahead, 0.7 * kStep);
		EXPECT_GT(btISTFirstTouch::meanDepthOf(contact), btISTFirstTouch::kShallow * thickness);
	}
}

// Where contact may be as deep as its stiffness lets it be, it is deeper only beyond twice its depth; else already by more than a touch.
TEST(btISTFirstTouch, ContactOfSetStiffnessCountsAsDeeperBeyondTwiceItsDepth)
{
	btCollisionObject objectA, objectB;
	const btISTShapeField none;
	const btISTQueryRules rules;
	const btISTPairQuery query(none, rules, true, false);
	QueryWorkspace workspace;
	btISTContact start;
	start.bodyA = &objectA;
	start.bodyB = &objectB;
	start.treeA = start.treeB = brick().tree;
	const double thickness = start.thickness(), depth = 0.1 * thickness;
	start.X_AB.translation = {0, 0.06 - depth, 0};
	query.queryAt(start, workspace);
	ASSERT_NEAR(btISTFirstTouch::meanDepthOf(start), depth, 0.02 * depth);
	const Vec3 center = brick().tree->origin;
	for (const bool followsLoad : {false, true})
		for (const double deeper : {0.03, 0.08, 0.15})
		{
			btISTContact contact = start;
			contact.constants.load = followsLoad ? 1 : 0;
			const btISTBodyMotion still{center, {}}, moving{contact.X_AB * center, {{0, -deeper * thickness / kStep, 0}, {}}};
			const bool isDeeper = btISTFirstTouch(query, still, moving, kStep).moveDeeper(contact, 0.4, workspace);
			EXPECT_EQ(isDeeper, deeper > (followsLoad ? 0.05 : 0.1)) << deeper << ' ' << followsLoad;
		}
}
