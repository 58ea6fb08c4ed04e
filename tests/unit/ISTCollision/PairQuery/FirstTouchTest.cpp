// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/PairQuery/btISTFirstTouch.h"

#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
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
