// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tree/BallTree.h"

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "BulletISTCollision/Core/Tree/TreeCheck.h"
#include "tests/unit/Core/Query/QueryBodies.h"
#include "tests/unit/Core/Tree/LooseTree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <random>
#include <span>

using namespace ist;

namespace
{
std::vector<MomentEllipsoid> cloud(int count, unsigned seed)
{
	std::mt19937 random(seed);
	std::uniform_real_distribution<float> place(-1, 1), radius(0.01f, 0.1f);
	std::vector<MomentEllipsoid> balls(static_cast<size_t>(count));
	for (MomentEllipsoid& b : balls)
	{
		b.x = place(random);
		b.y = place(random);
		b.z = place(random);
		b.R = radius(random);
		b.density = 0.9f;
		b.nx = 1;
		giveRandomShape(b, random);
	}
	return balls;
}

std::vector<std::array<float, 16>> sorted(std::span<const MomentEllipsoid> balls)
{
	std::vector<std::array<float, 16>> keys;
	for (const MomentEllipsoid& b : balls)
		if (b.density > 0)
		{
			keys.emplace_back();
			std::memcpy(keys.back().data(), &b, sizeof b);
		}
	std::sort(keys.begin(), keys.end());
	return keys;
}

std::vector<MomentEllipsoid> stored(std::vector<MomentEllipsoid> balls)
{
	std::transform(balls.begin(), balls.end(), balls.begin(), asStored);
	return balls;
}

std::vector<MomentEllipsoid> ballsBelow(const BallTree& tree, uint32_t child)
{
	std::vector<MomentEllipsoid> below;
	std::vector<uint32_t> open{child};
	while (!open.empty())
	{
		const uint32_t at = open.back();
		open.pop_back();
		if (at == BallNode::kNoChild) continue;
		if (at & BallNode::kLeafBit)
		{
			const size_t block = at & ~BallNode::kLeafBit;
			for (size_t i = 0; i < tree.ballCount(block); ++i) below.push_back(tree.ball(block * kBlockWidth + i));
			continue;
		}
		open.insert(open.end(), tree.nodes[at].child, tree.nodes[at].child + BallNode::kWidth);
	}
	return below;
}

/// Upper bound of the radius of the smallest sphere around the balls.
double leastSphere(const std::vector<MomentEllipsoid>& balls)
{
	Vec3 c = balls[0].center();
	double least = 1e300;
	for (int step = 1; step <= 500; ++step)
	{
		const MomentEllipsoid* farthest = nullptr;
		double reach = -1;
		for (const MomentEllipsoid& b : balls)
		{
			const double d = distance(b.center(), c) + b.R;
			if (d <= reach) continue;
			reach = d;
			farthest = &b;
		}
		least = std::min(least, reach);
		c += (farthest->center() - c) * (1.0 / (step + 1));
	}
	return least;
}
}  // namespace

TEST(BallTree, HoldsEveryBallOnceAndIsValid)
{
	for (const int count : {1, 2, 15, 16, 17, 100, 129, 3000, 20000})
	{
		const std::vector<MomentEllipsoid> balls = cloud(count, 7);
		const BallTree tree = buildBallTree(balls);
		EXPECT_EQ(tree.validate(), "") << count;
		EXPECT_EQ(tree.ballCount(), uint32_t(count));
		EXPECT_EQ(tree.blockCount(), size_t(count + 15) / 16);
		EXPECT_EQ(sorted(tree.slots()), sorted(stored(balls)));
	}
}

TEST(NormalGradient, IsRoundedToTheNearestUpperHalfOfAFloat)
{
	std::mt19937 random(9);
	std::uniform_real_distribution<double> u(-1, 1);
	for (int i = 0; i < 1000; ++i)
	{
		const auto value = [&] { return u(random) * std::pow(10, 20 * u(random)); };
		const SymmetricMatrix3 G{value(), value(), value(), value(), value(), value()};
		NormalGradient gradient;
		gradient.setMatrix(G);
		const SymmetricMatrix3 found = gradient.matrix();
		for (double SymmetricMatrix3::*entry : {&SymmetricMatrix3::xx, &SymmetricMatrix3::yy, &SymmetricMatrix3::zz, &SymmetricMatrix3::xy,
				 &SymmetricMatrix3::xz, &SymmetricMatrix3::yz})
			EXPECT_LE(std::fabs(found.*entry - G.*entry), std::fabs(G.*entry) / 255);
	}
	EXPECT_EQ(NormalGradient().matrix().trace(), 0);
}

TEST(StoredEllipsoid, IsRoundedToTheNearestStep)
{
	std::mt19937 random(10);
	std::uniform_real_distribution<float> u(-1, 1);
	for (int i = 0; i < 2000; ++i)
	{
		MomentEllipsoid e;
		e.setPlace({u(random), u(random), u(random)});
		e.R = std::pow(10.0f, 12 * u(random));
		e.density = 0.5f;
		giveRandomShape(e, random, MomentEllipsoid::kFlattest);
		e.setNormal(normalized(Vec3{u(random), u(random), u(random)}) * (i % 2 ? 1 : 0.1));
		e.depth = u(random);
		e.sphere = uint32_t(i);
		const MomentEllipsoid found = asStored(e);
		// The tolerance is slightly more than half a step, because the numbers are returned as floats.
		const double half = 0.501 * StoredEllipsoid::kStep, square = double(e.R) * e.R;
		for (float MomentEllipsoid::*n : {&MomentEllipsoid::nx, &MomentEllipsoid::ny, &MomentEllipsoid::nz})
			EXPECT_NEAR(found.*n, e.*n, half);
		for (float MomentEllipsoid::*p : {&MomentEllipsoid::xx, &MomentEllipsoid::yy, &MomentEllipsoid::zz, &MomentEllipsoid::xy,
				 &MomentEllipsoid::xz, &MomentEllipsoid::yz})
			EXPECT_NEAR(found.*p, e.*p, half * square);
		for (float MomentEllipsoid::*same : {&MomentEllipsoid::x, &MomentEllipsoid::y, &MomentEllipsoid::z, &MomentEllipsoid::R,
				 &MomentEllipsoid::density, &MomentEllipsoid::depth})
			EXPECT_EQ(found.*same, e.*same);
		EXPECT_EQ(found.sphere, e.sphere);
		EXPECT_TRUE(found.isSolid()) << "the thinnest, and those that touch their bounding ball";
		const MomentEllipsoid again = asStored(found);
		EXPECT_EQ(std::memcmp(&again, &found, sizeof found), 0) << "once rounded, always the same";
	}
}

TEST(StoredEllipsoid, OfWhatIsNoEllipsoidMakesNoValidTree)
{
	const auto refused = [](auto change) {
		std::vector<MomentEllipsoid> balls = cloud(20, 5);
		change(balls[7]);
		const BallTree tree = buildBallTree(balls);
		return !tree.validate().empty() && !surelyValid(tree);
	};
	EXPECT_FALSE(refused([](MomentEllipsoid&) {}));
	EXPECT_TRUE(refused([](MomentEllipsoid& e) { e.ny = NAN; }));
	EXPECT_TRUE(refused([](MomentEllipsoid& e) { e.nx = -INFINITY; }));
	EXPECT_TRUE(refused([](MomentEllipsoid& e) { e.nz = 1.5f; }));
	EXPECT_TRUE(refused([](MomentEllipsoid& e) { e.xy = NAN; }));
	EXPECT_TRUE(refused([](MomentEllipsoid& e) { e.zz = INFINITY; }));
	EXPECT_TRUE(refused([](MomentEllipsoid& e) { e.xx *= 1.5f; }));
}

TEST(BallTree, EveryBallKeepsItsGradientAndItsSphere)
{
	const auto gradientAt = [](const MomentEllipsoid& b) {
		NormalGradient gradient;
		gradient.setMatrix({b.x, b.y, b.z, 2 * b.x, 3 * b.y, 4 * b.z});
		return gradient;
	};
	std::vector<MomentEllipsoid> balls = cloud(1000, 7);
	std::vector<NormalGradient> gradients;
	for (size_t i = 0; i < balls.size(); ++i)
	{
		balls[i].sphere = uint32_t(5000 - 3 * i);
		gradients.push_back(gradientAt(balls[i]));
	}
	const BallTree tree = buildBallTree(balls, gradients);
	EXPECT_EQ(tree.validate(), "");
	EXPECT_EQ(sorted(tree.slots()), sorted(stored(balls)));
	ASSERT_EQ(tree.gradients.size(), tree.slotCount());
	for (size_t slot = 0; slot < tree.slotCount(); ++slot)
	{
		const MomentEllipsoid ball = tree.ball(slot);
		if (!(ball.density > 0)) continue;
		const SymmetricMatrix3 G = tree.gradients[slot].matrix(), expected = gradientAt(ball).matrix();
		EXPECT_EQ(G.zz, expected.zz);
		EXPECT_EQ(G.xy, expected.xy);
		EXPECT_EQ(balls[(5000 - ball.sphere) / 3].center(), ball.center());
	}
}

TEST(BallTree, TheThreadCountChangesNothing)
{
	const std::vector<MomentEllipsoid> balls = cloud(30000, 11);
	const BallTree one = buildBallTree(balls, 1);
	for (const int threads : {2, 5})
	{
		const BallTree many = buildBallTree(balls, threads);
		EXPECT_EQ(sorted(many.slots()), sorted(one.slots()));
		ASSERT_EQ(many.nodes.size(), one.nodes.size());
		ASSERT_EQ(many.slotCount(), one.slotCount());
		EXPECT_EQ(std::memcmp(many.nodes.data(), one.nodes.data(), one.nodes.size() * sizeof(BallNode)), 0);
		EXPECT_EQ(std::memcmp(many.balls.data(), one.balls.data(), one.balls.size() * sizeof(Sphere)), 0);
	}
}

// For a large node the build considers only the outermost balls and takes a tenth of the steps.
TEST(BallTree, LargeNodesAreBoundedAlmostAsTightlyAsCanBe)
{
	for (const unsigned seed : {21u, 22u})
	{
		const BallTree tree = buildBallTree(cloud(40000, seed));
		const BallNode& root = tree.nodes[0];
		for (int k = 0; k < BallNode::kWidth; ++k)
		{
			ASSERT_NE(root.child[k], BallNode::kNoChild);
			EXPECT_LE(root.r[k], 1.03 * leastSphere(ballsBelow(tree, root.child[k])));
		}
	}
}

TEST(BallTree, EmptyCloudGivesEmptyTree)
{
	const BallTree tree = buildBallTree({});
	EXPECT_TRUE(tree.empty());
	EXPECT_EQ(tree.ballCount(), 0u);
	EXPECT_EQ(tree.validate(), "");
}

TEST(BallTree, CoincidentAndSkewedCloudsStayShallow)
{
	std::vector<MomentEllipsoid> same(5000, cloud(1, 3)[0]);
	EXPECT_EQ(buildBallTree(same).validate(), "");
	std::vector<MomentEllipsoid> skewed = cloud(5000, 4);
	for (size_t i = 0; i < skewed.size(); ++i) skewed[i].x = std::pow(2.0f, float(i % 50) - 25);
	EXPECT_EQ(buildBallTree(skewed).validate(), "");
}

TEST(BallTree, ValidateFindsDamage)
{
	const BallTree good = buildBallTree(cloud(1000, 5));
	const auto damaged = [&](auto change) {
		LooseTree tree(good);
		change(tree);
		return tree.frozen().validate();
	};
	EXPECT_NE(damaged([](LooseTree& t) { t.nodes[0].child[0] = 100000; }), "");
	EXPECT_NE(damaged([](LooseTree& t) { t.nodes[0].child[0] = 0; }), "");
	EXPECT_NE(damaged([](LooseTree& t) { t.nodes[0].child[1] = t.nodes[0].child[0]; }), "");
	EXPECT_NE(damaged([](LooseTree& t) { t.nodes[0].child[0] = BallNode::kNoChild; }), "");
	EXPECT_NE(damaged([](LooseTree& t) { t.nodes[0].r[0] *= 0.5f; }), "");
	EXPECT_NE(damaged([](LooseTree& t) { t.nodes[0].x[0] = NAN; }), "");
	EXPECT_NE(damaged([](LooseTree& t) { t.nodes[0].r[0] = kFarthestBound; }), "");
	EXPECT_NE(damaged([](LooseTree& t) { t.balls[50].r = 0; }), "");
	EXPECT_NE(damaged([](LooseTree& t) { t.balls[50].x += 1; }), "");
	EXPECT_NE(damaged([](LooseTree& t) { t.balls[5].y = INFINITY; }), "");
	EXPECT_NE(damaged([](LooseTree& t) { t.ellipsoids[5].density = 0; }), "");
	EXPECT_NE(damaged([](LooseTree& t) { t.ellipsoids[5].depth = NAN; }), "");
	EXPECT_EQ(damaged([](LooseTree& t) { t.ellipsoids[5].density = 1e30f; }).substr(0, 27), "density or depth of no body");
	EXPECT_EQ(damaged([](LooseTree& t) { t.ellipsoids[5].depth = -1e30f; }).substr(0, 27), "density or depth of no body");
	EXPECT_NE(damaged([](LooseTree& t) { t.ellipsoids[5].shape[1] = 0; }), "");
	EXPECT_NE(damaged([](LooseTree& t) { t.ellipsoids.pop_back(); }), "");
	EXPECT_NE(damaged([](LooseTree& t) { t.balls.pop_back(); }), "");
	EXPECT_NE(damaged([](LooseTree& t) { t.nodes.clear(); }), "");
	EXPECT_NE(damaged([](LooseTree& t) { t.sphereIndex.resize(t.balls.size()); }), "");
	EXPECT_EQ(damaged([](LooseTree& t) {
		t.balls.clear();
		t.ellipsoids.clear();
		t.nodes.resize(1);
		std::fill(t.nodes[0].child, t.nodes[0].child + BallNode::kWidth, BallNode::kNoChild);
		std::fill(t.nodes[0].r, t.nodes[0].r + BallNode::kWidth, 0.0f);
	}),
		"nodes without blocks");
	EXPECT_EQ(damaged([](LooseTree& t) { t.gradients.resize(t.balls.size()); }), "");
	EXPECT_EQ(damaged([](LooseTree& t) { t.gradients.resize(t.balls.size() - 1); }), "not one gradient for each ball");
	EXPECT_NE(damaged([](LooseTree& t) {
		t.gradients.resize(t.balls.size());
		t.gradients[7].setMatrix({0, 0, 0, 0, 0, NAN});
	}),
		"");
}

TEST(BallTree, ValidateRefusesAChainDeeperThanQueriesAllow)
{
	LooseTree tree(buildBallTree(cloud(1, 5)));
	const BallNode leaf = tree.nodes[0];
	tree.nodes.assign(200, leaf);
	for (uint32_t i = 0; i + 1 < 200; ++i) tree.nodes[i].child[0] = i + 1;
	EXPECT_EQ(tree.frozen().validate(), "tree too deep");
}

TEST(BallTree, TakesFewBytesABall)
{
	const std::vector<MomentEllipsoid> balls = cloud(5000, 8);
	EXPECT_LE(double(buildBallTree(balls).memory()), 51.0 * 5000);
	EXPECT_LE(double(packedTree(balls).memory()), 23.0 * 5000);
}

TEST(BallTree, BallsOfPackedSpheresAreTheirs)
{
	const std::vector<MomentEllipsoid> balls = cloud(100, 9);
	const BallTree tree = packedTree(balls);
	ASSERT_EQ(tree.validate(), "");
	std::vector<uint32_t> found;
	for (size_t slot = 0; slot < tree.slotCount(); ++slot)
	{
		const MomentEllipsoid ball = tree.ball(slot);
		if (ball.density == 0) continue;
		found.push_back(ball.sphere);
		const MomentEllipsoid& source = balls[ball.sphere];
		EXPECT_EQ(ball.center(), source.center());
		EXPECT_EQ(ball.R, source.R);
		EXPECT_EQ(ball.density, 1);
		EXPECT_EQ(ball.shape().xx, source.R * source.R);
		EXPECT_EQ(norm(ball.normal()), 0);
	}
	std::sort(found.begin(), found.end());
	ASSERT_EQ(found.size(), balls.size());
	for (uint32_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i], i);
}

TEST(InnerSphereTree, ValidateNamesTheTree)
{
	InnerSphereTree body;
	body.volume = 1;
	body.law = body.cells = buildBallTree(cloud(50, 1));
	body.inner = packedTree(cloud(50, 1));
	EXPECT_EQ(body.validate(), "");
	std::swap(body.law, body.inner);
	EXPECT_NE(body.validate().find("law"), std::string::npos);
	std::swap(body.law, body.inner);
	LooseTree empty(body.cells);
	for (int k = 0; k < kBlockWidth; ++k) empty.balls[size_t(k)].r = 0;
	body.cells = empty.frozen();
	EXPECT_NE(body.validate().find("cells"), std::string::npos);
	body.cells = {};
	EXPECT_NE(body.validate(), "");
	body.cells = body.law;
	body.volume = -1;
	EXPECT_NE(body.validate(), "");
}
