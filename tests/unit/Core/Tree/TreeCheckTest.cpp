// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tree/TreeCheck.h"

#include "tests/unit/Core/Query/QueryBodies.h"
#include "tests/unit/Core/Tree/LooseTree.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <random>

namespace ist
{
namespace
{
BallTree randomTree(size_t count, double scale, double farOff, uint64_t seed)
{
	std::mt19937_64 random(seed);
	std::uniform_real_distribution<double> at(-scale, scale), radius(0.001 * scale, 0.1 * scale);
	std::vector<MomentEllipsoid> balls(count);
	for (MomentEllipsoid& b : balls)
	{
		b.x = float(farOff + at(random));
		b.y = float(at(random));
		b.z = float(at(random));
		b.R = float(radius(random));
		b.density = 0.9f;
		b.nx = 0.5f;
		giveRandomShape(b, random);
	}
	return buildBallTree(balls);
}

/// A tree of packed spheres at the places of a tree's balls.
BallTree packedOf(const BallTree& tree)
{
	std::vector<MomentEllipsoid> balls;
	for (const MomentEllipsoid& b : tree.slots())
		if (b.density > 0) balls.push_back(b);
	return packedTree(balls);
}

TEST(TreeCheck, PassesWhatTheBuilderMakes)
{
	for (size_t count : {1, 15, 16, 17, 400, 20000})
		for (double scale : {1e-3, 1.0, 1e4})
			for (double farOff : {0.0, 1000.0})
			{
				const BallTree tree = randomTree(count, scale, farOff, count);
				EXPECT_TRUE(surelyValid(tree)) << count << ' ' << scale << ' ' << farOff;
				EXPECT_TRUE(surelyValid(packedOf(tree))) << count << ' ' << scale << ' ' << farOff;
			}
}

TEST(TreeCheck, RefusesBodiesTooLargeForTheirMoments)
{
	for (const double scale : {1e7, 1e8, 1e9, 9e11})
	{
		const BallTree tree = randomTree(400, scale, 0, 3);
		const std::string problem = tree.validate();
		EXPECT_EQ(problem.empty(), scale == 1e7) << scale << ": " << problem;
		EXPECT_EQ(surelyValid(tree), scale == 1e7) << scale;
		EXPECT_EQ(surelyValid(packedOf(tree)), scale == 1e7) << scale;
	}
}

constexpr float kOdd[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1.0f, 0.0f, 1e30f};

/// Changes one number of an ellipsoid.
void damage(StoredEllipsoid& ellipsoid, const std::function<size_t(size_t)>& below)
{
	const size_t of = below(8);
	if (of < 6)
	{
		int16_t& entry = ellipsoid.shape[of];
		entry = below(2) ? int16_t(int(below(65536)) - 32768) : int16_t(entry * (0.9 + 0.0005 * double(below(200))));
		return;
	}
	float& number = of == 6 ? ellipsoid.depth : ellipsoid.density;
	number = below(2) ? kOdd[below(std::size(kOdd))] : number * (0.9f + 0.001f * float(below(200)));
}

/// Changes one number of the tree.
void damage(LooseTree& tree, std::mt19937_64& random)
{
	const auto below = [&](size_t n) { return std::uniform_int_distribution<size_t>(0, n - 1)(random); };
	BallNode& node = tree.nodes[below(tree.nodes.size())];
	const size_t index = below(tree.balls.size()), lane = below(BallNode::kWidth);
	const bool packed = tree.ellipsoids.empty();
	Sphere& ball = tree.balls[index];
	switch (below(11))
	{
	case 0: node.r[lane] *= 0.9f + 0.0001f * float(below(1000)); break;
	case 1: node.x[lane] += node.r[lane] * 0.0001f * float(below(1000)); break;
	case 2: node.child[lane] = uint32_t(below(tree.nodes.size())); break;
	case 3: node.child[lane] = BallNode::kLeafBit | uint32_t(below(tree.balls.size() / kBlockWidth + 1)); break;
	case 4: node.r[lane] = below(4) == 0 ? kFarthestBound : kOdd[below(std::size(kOdd))]; break;
	case 5: ball.r = kOdd[below(std::size(kOdd))]; break;
	case 6: ball.x = kOdd[below(std::size(kOdd))]; break;
	case 7: ball.z += 0.01f * float(below(3)); break;
	case 8: ball.r *= 1 + 0.01f * float(below(100)); break;
	default:
		if (!packed) return damage(tree.ellipsoids[index], below);
		ball.r *= 0.9f + 0.001f * float(below(200));
	}
}

TEST(TreeCheck, RefusesArraysThatDoNotBelongTogether)
{
	const BallTree ellipsoids = randomTree(100, 1, 0, 3);
	for (const BallTree& original : {ellipsoids, packedOf(ellipsoids)})
	{
		const auto refused = [&](auto change) {
			LooseTree tree(original);
			change(tree);
			return !surelyValid(tree.frozen()) && !tree.frozen().validate().empty();
		};
		EXPECT_FALSE(refused([](LooseTree&) {}));
		EXPECT_TRUE(refused([](LooseTree& t) { t.balls.pop_back(); }));
		EXPECT_TRUE(refused([](LooseTree& t) { t.sphereIndex.resize(t.ellipsoids.empty() ? t.balls.size() - 1 : t.balls.size()); }));
		EXPECT_TRUE(refused([](LooseTree& t) { t.ellipsoids.resize(t.ellipsoids.empty() ? t.balls.size() : t.balls.size() - 1); }));
	}
}

// The slow check is the oracle: it must accept every tree that the quick check accepts. The quick check may reject valid trees, but
// rarely does.
TEST(TreeCheck, NeverPassesWhatValidateRefuses)
{
	const BallTree ellipsoids = randomTree(600, 1, 3, 7);
	for (const BallTree& original : {ellipsoids, packedOf(ellipsoids)})
	{
		std::mt19937_64 random(11);
		int valid = 0, passed = 0, refused = 0;
		for (int round = 0; round < 4000; ++round)
		{
			LooseTree loose(original);
			damage(loose, random);
			const BallTree tree = loose.frozen();
			const bool sound = tree.validate().empty(), sure = surelyValid(tree);
			ASSERT_TRUE(sound || !sure) << "round " << round << ": " << tree.validate();
			valid += sound;
			passed += sure;
			refused += !sound;
		}
		EXPECT_GT(refused, 1000);
		EXPECT_GT(valid, 500);
		EXPECT_GT(passed, valid * 9 / 10);
	}
}
}  // namespace
}  // namespace ist
